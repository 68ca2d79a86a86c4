// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cells of an unbounded grid as keys of hash tables.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "packMesh/core/vector.h"

namespace packmesh {

using GridIndex = std::array<std::int64_t, 3>;

/// The cell with edges of these lengths that contains a point; one begins at the origin [µm].
inline GridIndex gridIndex(const Vec3& p, const Vec3& edge) {
  GridIndex cell;
  for (int k = 0; k < 3; ++k) cell[k] = std::int64_t(std::floor(p[k] / edge[k]));
  return cell;
}

/// Different for cells within 2^20 of the origin along each axis.
inline std::int64_t keyOf(const GridIndex& cell) {
  constexpr std::int64_t range = std::int64_t(1) << 21;
  return (cell[2] * range + cell[1]) * range + cell[0];
}

}  // namespace packmesh
