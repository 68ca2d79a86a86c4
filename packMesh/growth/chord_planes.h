// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Planes from chords between neighbours: the chordal surface without tetrahedra.
#pragma once

#include <memory>
#include <vector>

#include "packMesh/certificate/periodic_neighbors.h"
#include "packMesh/field/sampled_distance.h"
#include "packMesh/growth/growth_state.h"
#include "packMesh/growth/levels_of_detail.h"
#include "packMesh/growth/resampling.h"
#include "packMesh/shape/surface_distance.h"

namespace packmesh {

/// Planes from distance fields.
///
/// A chord joins a sample point of one cell to the foot of its perpendicular on a neighbour (or periodic
/// image). The plane across the middle of the chord separates its ends; both cells get it, each for its own
/// end. That is what the faces of CAT cells are made from too (thesis 3.1.2), with chords that tetrahedra
/// pick instead of the nearest ones. At walls, which do not move, the plane lies at the foot, and
/// neighbouring parts of the wall that run in another direction (edges, corners) add planes of their own.
class ChordPlanes {
 public:
  /// References the scene, which must outlive this.
  explicit ChordPlanes(const GrowthScene& scene);

  /// Planes for chords that are short enough to matter in the request. Pre: no two cells overlap
  PlaneConstraints operator()(const GrowthState& state, const PlaneRequest& request) const;

  /// The planes at walls alone.
  PlaneConstraints atWalls(const GrowthState& state, const PlaneRequest& request) const;

  const LevelsOfDetail& levels(int species) const { return species_[species].levels; }

 private:
  struct Species {
    const Shape* shape;
    SurfaceDistance field;
    const Wall* wall;
    std::shared_ptr<const SampledDistance> sampledWall;  ///< asked instead where the wall has no closed form
    LevelsOfDetail levels;
    std::vector<SamplePoints> points;  ///< of each level

    WallDistance toWall(const Vec3& p) const {
      return sampledWall ? sampledWall->sample(p) : wall->distance(p);
    }
  };
  /// A cell with what all its chords need.
  struct Cell {
    int species;
    Mat3 rotation;
    Vec3 position;
    double scale, reach;
    const SamplePoints* points;
    bool frozen;
    bool wanted;  ///< planes of this one
  };

  std::vector<Cell> cellsOf(const GrowthState& state, const PlaneRequest& request) const;
  void meetWalls(const std::vector<Cell>& cells, PlaneConstraints& planes) const;
  void joinPair(const NearPair& pair, const std::vector<Cell>& cells, PlaneConstraints& planes) const;
  void dropChords(int from, int onto, const Vec3& ontoShift, const std::vector<Cell>& cells,
                  PlaneConstraints& planes) const;
  void meetWall(int cell, const std::vector<Cell>& cells, PlaneConstraints& planes) const;

  const GrowthScene& scene_;
  std::vector<Species> species_;
};

}  // namespace packmesh
