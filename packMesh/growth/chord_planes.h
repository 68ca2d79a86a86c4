// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Planes from chords between neighbours: the chordal surface without tetrahedra.
#pragma once

#include <memory>
#include <vector>

#include "packMesh/field/sampled_distance.h"
#include "packMesh/growth/plane_function.h"
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
class ChordPlanes : public PlaneFunction {
 public:
  /// References the scene, which must outlive this.
  explicit ChordPlanes(const GrowthScene& scene);

  /// Planes for chords that are short enough to matter in the request.
  PlaneConstraints operator()(const PlaneRequest& request) override;

  /// Only the planes at walls and borders of regions.
  PlaneConstraints atWalls(const PlaneRequest& request) const;

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
    bool fixed;
    PlaneConstraints::pointer planes;  ///< where its planes go; nullptr: they are not wanted
  };

  Cell cellOf(std::int64_t index, const PlaneRequest& request) const;
  void meetSurroundings(const PlaneRequest& request, PlaneConstraints& planes) const;
  void joinPair(const NearPair& pair, const Cell& a, const Cell& b) const;
  void dropChords(const Cell& from, const Cell& onto, const Vec3& ontoShift) const;
  void meetWall(const Cell& cell) const;
  void meetRegion(const Cell& cell) const;

  const GrowthScene& scene_;
  std::vector<Species> species_;
};

}  // namespace packmesh
