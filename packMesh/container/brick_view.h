// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The bricks of a SampledWall as plain data, for code that asks many points at once.
///
/// This header must not pull in templates of other libraries (see contact_kernel.h).
#pragma once

namespace packmesh {

class SampledWall;

/// Bricks of cells between nodes, in each of which the distance is interpolated.
struct BrickView {
  static constexpr int cells = 8;          ///< along the edge of a brick
  static constexpr int row = cells + 1;    ///< nodes along it, those on its faces included
  static constexpr int slab = row * row;   ///< nodes of a face
  static constexpr int nodes = slab * row;

  /// Of brick (i,j,k) at i + bricks[0] * (j + bricks[1] * k): the distances at its nodes [µm], x fastest. All
  /// are NaN while they are not known.
  const float* const* brick;
  int bricks[3];
  float nodesPerLength;  ///< [1/µm]
  const SampledWall* wall;

  /// Makes brick `index` known.
  void (*evaluate)(const SampledWall& wall, int index);
};

}  // namespace packmesh
