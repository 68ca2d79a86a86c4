// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Planes from chords between neighbours: the chordal surface without tetrahedra.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "packMesh/cat/growing_cells.h"
#include "packMesh/cat/growth_kernels.h"
#include "packMesh/cat/levels_of_detail.h"
#include "packMesh/field/sampled_distance.h"
#include "packMesh/shape/surface_distance.h"

namespace packmesh {

/// Planes from distance fields.
///
/// A chord joins a sample point of one cell to the nearest point on a neighbour (or periodic image). The
/// perpendicular plane through the middle of the chord separates its ends; both cells receive it, each for
/// its own end. The faces of CAT cells are constructed in the same way (thesis 3.1.2), from the chords that
/// tetrahedra select instead of the shortest ones. At walls, which do not move, the plane passes through the
/// nearest point, and neighbouring parts of the wall with another direction (edges, corners) add planes of
/// their own.
class ChordPlanes : public PlaneFunction {
 public:
  /// References `physics`, which must outlive this.
  explicit ChordPlanes(const Physics& physics);

  /// Planes for chords that are short enough to be relevant in the request.
  void operator()(const PlaneRequest& request, std::vector<CellPlanes>& planes) override;
  /// Fewer planes save more time than the halving of a few more steps costs; with CAT faces it costs more.
  double expectedShare() const override { return 0.25; }

  /// Adds only the planes at walls and at the boundaries of regions.
  void addAtWalls(const PlaneRequest& request, std::vector<CellPlanes>& planes) const;

  /// Vertices of a cell in its body frame.
  struct Vertices {
    const std::vector<Vec3>* points;
    const std::vector<double>* within;  ///< distances beyond which they do not count [µm at scale 1]
  };
  /// Marks the vertices of the two cells of a pair that are within reach of the surface of the other cell.
  void markWithinReach(const PlaneRequest& request, const NearPair& pair,
                       const std::array<Vertices, 2>& vertices,
                       const std::array<std::vector<char>*, 2>& marks) const;

  const LevelsOfDetail& levels(int shape) const { return surfaces_[shape]->levels; }

 private:
  /// A shape in use.
  struct Surface {
    const Shape* shape;
    SurfaceDistance field;
    LevelsOfDetail levels;
    FieldView view;                    ///< of the shape
    std::vector<SamplePoints> points;  ///< of each level
    /// Of each level, per cluster: which points are no repetitions, as bits.
    std::vector<std::vector<std::uint16_t>> distinct;
  };
  /// That of a species.
  struct MetWall {
    const Wall* wall;                                ///< nullptr: none
    std::shared_ptr<const SampledDistance> sampled;  ///< used instead if the wall has no closed form

    WallDistance toWall(const Vec3& p) const { return sampled ? sampled->sample(p) : wall->distance(p); }
  };
  /// A cell with everything that its chords require.
  struct Cell {
    int species, shape;
    Mat3 rotation;
    Vec3 position;
    double scale, reach;
    int level;  ///< of detail
    bool fixed;
    CellPlanes* planes;  ///< receives its planes; nullptr: they are not requested
  };

  std::vector<int> levelsOf(const PlaneRequest& request) const;
  Cell cellOf(std::int64_t index, const PlaneRequest& request, const std::vector<int>& levels) const;
  void joinPair(const NearPair& pair, const Cell& a, const Cell& b) const;
  void dropChords(const Cell& from, const Cell& onto, const Vec3& ontoShift) const;
  void meetWall(const Cell& cell) const;
  void meetRegion(const Cell& cell) const;

  const Physics& physics_;
  std::vector<std::unique_ptr<const Surface>> surfaces_;  ///< per shape
  std::vector<MetWall> walls_;                            ///< per species
  ChordKernel kernel_;
};

}  // namespace packmesh
