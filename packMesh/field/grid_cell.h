// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Location of a point in a grid.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "packMesh/core/vector.h"
#include "packMesh/field/trilinear.h"

namespace packmesh {

/// The grid cell that contains a point, or the nearest point of the grid to it.
struct GridCell {
  int node[3];    ///< its low corner
  double t[3];    ///< position in the cell, 0 to 1 along each axis
  Vec3 beyond;    ///< from the nearest point of the grid to the point [cells]
  bool isBeyond;  ///< outside the grid

  /// @param u the point, relative to the first node [cells]
  /// @param cells of the grid along each axis, at least 1
  GridCell(const Vec3& u, const std::array<int, 3>& cells) : isBeyond(false) {
    for (int k = 0; k < 3; ++k) {
      const double last = cells[k], inside = u[k] > 0.0 ? std::min(u[k], last) : 0.0;
      node[k] = std::min(static_cast<int>(inside), cells[k] - 1);
      t[k] = inside - node[k];
      beyond[k] = u[k] - inside;
      isBeyond |= u[k] < 0.0 || u[k] > last;
    }
  }

  /// Interpolates between values with strides `row` along y and `slab` along z.
  /// @param valueAt returns the value at this offset from that of the low corner
  template <class ValueAt>
  Trilinear<double> interpolate(std::size_t row, std::size_t slab, ValueAt valueAt) const {
    double corner[8];
    for (int c = 0; c < 8; ++c) corner[c] = valueAt((c & 1) + (c & 2 ? row : 0) + (c & 4 ? slab : 0));
    return {corner, t};
  }
};

}  // namespace packmesh
