// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Statistics of a packing: profiles of the volume fraction, gaps, orientation.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "packMesh/analysis/cell_measures.h"
#include "packMesh/container/container.h"

namespace packmesh {

/// Distance to a wall: exact near the wall and if it has a closed form. Further than three node spacings from
/// the wall, where the search for the nearest triangle is slow, it is interpolated linearly between exact
/// distances at about 32,000 nodes in the box, which are computed when needed, one by one: whole Bricks of
/// them would need 1.5 to 2.4 times as many searches (in cylinders with a radius of 10 to 25 µm).
/// Threads can share it.
class WallDepth {
 public:
  /// References `wall`, which must outlive this object. @param box contains all points
  WallDepth(const Wall& wall, const Box& box);

  /// Positive inside the lumen [µm]. Pre: `p` is in the box, up to rounding.
  double operator()(const Vec3& p) const;

  double spacing() const { return spacing_; }  ///< of the nodes [µm]

 private:
  double node(std::size_t index) const;

  const Wall& wall_;
  const Box box_;
  bool exact_;
  double spacing_ = 0.0;
  std::array<int, 3> cells_ = {1, 1, 1};
  mutable std::vector<std::atomic<double>> nodes_;  ///< [µm]; NaN: not yet computed
};

/// Volume fractions in layers of equal width.
///
/// Every cell's volume is distributed evenly over points inside it (innerPoints()), so the total over all
/// layers is exact. Lumens with a wall are sampled at one random point in each cube of a grid. `error` is the
/// standard error for independent points; evenly distributed points have a smaller one.
struct Profile {
  double begin = 0.0, width = 1.0;            ///< layer i: begin + [i, i+1) * width [µm]
  std::vector<double> lumen;                  ///< volume of each layer [µm³]
  std::vector<std::vector<double>> fraction;  ///< volume fraction, [species][layer]
  std::vector<std::vector<double>> error;     ///< standard error of `fraction`
  std::vector<double> red;                    ///< of all species with Species::inHematocrit, [layer]

  int layers() const { return static_cast<int>(lumen.size()); }
  double middle(int layer) const { return begin + (layer + 0.5) * width; }
};

/// Distance from the wall at which the hematocrit first reaches `share` [fraction] of its mean over all
/// layers [µm]: linear between the centres of layers, 0 at the wall. Empty if it is never reached.
std::optional<double> layerBelow(const Profile& profile, double share);

struct GapHistogram {
  double width = 0.02;               ///< bin i: [i, i+1) * width [µm]; gaps below 0 are in the first
  std::vector<std::int64_t> counts;  ///< up to the largest gap that was measured
  std::int64_t beyond = 0;           ///< cells without a neighbour within it
  /// Of cells with such a neighbour [µm]; 0 if there are none. The median is accurate to one bin.
  double minimum = 0.0, mean = 0.0, median = 0.0;
};

/// Orientational order of the cells' symmetry axes n (axis y of the templates); n and -n are equivalent.
struct OrientationOrder {
  std::int64_t cells = 0;
  Mat3 tensor = Mat3::Zero();       ///< mean of (3 n nᵀ - 1) / 2, traceless
  Vec3 eigenvalues = Vec3::Zero();  ///< of the tensor, in descending order
  /// Number of cells with |n·x|, |n·y|, |n·z| in each tenth from 0 to 1: equal numbers if there is no order.
  std::array<std::array<std::int64_t, 10>, 3> cosines{};
  Vec3 director = Vec3::Zero();  ///< unit eigenvector of the largest; largest component positive
  /// Order parameter S, the largest eigenvalue. 1: all parallel; about 1/√cells: no order; the smallest
  /// eigenvalue near -1/2: all in a plane.
  double nematic() const { return eigenvalues[0]; }
};

struct PackingMeasures {
  std::optional<Profile> wall;                ///< over the distance to the wall, if there is a wall
  std::array<Profile, 3> axial;               ///< over x, y, z
  std::vector<GapHistogram> gaps;             ///< per species
  std::vector<OrientationOrder> orientation;  ///< per species
  int pointsPerCell = 0;
  std::int64_t leftOut = 0;      ///< number of cells that profiles leave out
  std::int64_t lumenPoints = 0;  ///< sample points; 0: the lumen fills its bounding box
};

/// Measures a packing; the result is the same on all ranks and for any number of ranks. Collective.
/// @param cells full-size cells of this rank
/// @param gaps gaps of these cells, see measureCells() [µm], measured up to `largestGap`
/// @param ends axes along which the lumen ends without a wall: points closer to such an end than to the wall
/// are excluded from `wall`
/// @param outside as for measureShare(): profiles leave them out
PackingMeasures measurePacking(const Physics& physics, const Execution& execution,
                               const std::vector<PlacedCell>& cells, const std::vector<double>& gaps,
                               const std::array<bool, 3>& ends, const std::set<std::int64_t>& outside = {},
                               double largestGap = usualGapOfInterest);

}  // namespace packmesh
