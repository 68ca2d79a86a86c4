// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Distances to a wall at many points, for statistics.
#pragma once

#include <vector>

#include "packMesh/container/container.h"

namespace packmesh {

/// Distance to a wall: exact near it and where the wall has a closed form; further in (or out) than three
/// spacings of some 32,000 nodes in the box, linear between exact distances at those nodes, which are found
/// when they are needed. There the search for the nearest triangle of a mesh takes long. Not for several
/// threads.
class WallDepth {
 public:
  /// References `wall`, which must outlive this. @param box of the points
  WallDepth(const Wall& wall, const Box& box);

  /// Positive inside the lumen [µm]. Pre: in the box, to rounding.
  double operator()(const Vec3& p) const;

  double spacing() const { return spacing_; }  ///< of the nodes [µm]

 private:
  double node(std::size_t index, int i, int j, int k) const;

  const Wall& wall_;
  const Box box_;
  bool exact_;
  double spacing_ = 0.0;
  int cells_[3] = {1, 1, 1};
  mutable std::vector<double> nodes_;  ///< NaN: not yet known
};

}  // namespace packmesh
