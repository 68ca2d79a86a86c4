// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Distances to a wall at many points, for statistics.
#pragma once

#include <array>
#include <vector>

#include "packMesh/container/container.h"

namespace packmesh {

/// Distance to a wall: exact near it and where the wall has a closed form; further in (or out) than three
/// spacings of some 32,000 nodes in the box, linear between exact distances at those nodes, which are found
/// when they are needed. There the search for the nearest triangle of a mesh takes long: nodes are searched
/// one by one, because whole Bricks of them would need 1.5 to 2.4 times as many searches (in cylinders
/// with a radius of 10 to 25 µm). Not for several threads.
class WallDepth {
 public:
  /// References `wall`, which must outlive this. @param box of the points
  WallDepth(const Wall& wall, const Box& box);

  /// Positive inside the lumen [µm]. Pre: in the box, to rounding.
  double operator()(const Vec3& p) const;

  double spacing() const { return spacing_; }  ///< of the nodes [µm]

 private:
  double node(std::size_t index) const;

  const Wall& wall_;
  const Box box_;
  bool exact_;
  double spacing_ = 0.0;
  std::array<int, 3> cells_ = {1, 1, 1};
  mutable std::vector<double> nodes_;  ///< NaN: not yet known
};

}  // namespace packmesh
