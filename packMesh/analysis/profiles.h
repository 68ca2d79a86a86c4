// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What a packing is like as a whole: where its cells are, how near to each other, which way they lie.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "packMesh/analysis/cell_measures.h"

namespace packmesh {

/// Volume fractions in layers of equal width.
///
/// Every cell's volume is spread evenly over points in it (innerPoints()), so that over all layers it is
/// exact; lumens with a wall are sampled at one random point in each of the cubes of a grid. `error` is the
/// standard error that points chosen independently would have; evenly spread ones have less.
struct Profile {
  double begin = 0.0, width = 1.0;            ///< layer i: begin + [i, i+1) * width [µm]
  std::vector<double> lumen;                  ///< volume of each layer [µm³]
  std::vector<std::vector<double>> fraction;  ///< [species][layer]
  std::vector<std::vector<double>> error;     ///< of fraction
  std::vector<double> red;                    ///< of AnalysisInput::inHematocrit together, [layer]

  int layers() const { return static_cast<int>(lumen.size()); }
  double middle(int layer) const { return begin + (layer + 0.5) * width; }
};

/// How far from the wall the hematocrit first reaches a share of its mean over all layers [µm]: linear
/// between the middles of layers, 0 at the wall. Empty when it never does.
std::optional<double> layerBelow(const Profile& profile, double share);

struct GapHistogram {
  double width = 0.02;               ///< bin i: [i, i+1) * width [µm]; gaps below 0 are in the first
  std::vector<std::int64_t> counts;  ///< up to farthestGap
  std::int64_t beyond = 0;           ///< cells without a neighbour within farthestGap
  /// Of the cells that have one [µm]; 0 when there are none. The median is right to a bin.
  double minimum = 0.0, mean = 0.0, median = 0.0;
};

/// Order of the cells' thin axes n (axis y of the templates), of which head and tail are the same.
struct OrientationOrder {
  std::int64_t cells = 0;
  Mat3 tensor = Mat3::Zero();       ///< mean of (3 n nᵀ - 1) / 2: no trace
  Vec3 eigenvalues = Vec3::Zero();  ///< of it, from the largest to the smallest
  /// How many cells have |n·x|, |n·y|, |n·z| in each tenth from 0 to 1: as many in each when there is no
  /// order.
  std::array<std::array<std::int64_t, 10>, 3> cosines{};
  Vec3 director = Vec3::Zero();  ///< unit eigenvector of the largest, its largest component positive
  /// S: the largest eigenvalue. 1: all parallel; about 1/√cells: no order; the smallest one near -1/2: all in
  /// a plane.
  double nematic() const { return eigenvalues[0]; }
};

struct PackingMeasures {
  std::optional<Profile> wall;                ///< over the distance to the wall, where there is one
  std::array<Profile, 3> axial;               ///< over x, y, z
  std::vector<GapHistogram> gaps;             ///< per species
  std::vector<OrientationOrder> orientation;  ///< per species
  int pointsPerCell = 0;
  std::int64_t lumenPoints = 0;  ///< that were looked at; 0: the lumen is its box
};

/// Measures a packing; the same on all ranks, whatever their number. All ranks call.
/// @param cells full-size cells of this rank
/// @param gaps of these cells, see measureCells() [µm]
/// @param ends axes along which the lumen ends, but not at a wall: what is nearer to such an end than to the
///   wall is left out of `wall`
PackingMeasures measurePacking(const AnalysisInput& analysis, const std::vector<PlacedCell>& cells,
                               const std::vector<double>& gaps, const std::array<bool, 3>& ends);

}  // namespace packmesh
