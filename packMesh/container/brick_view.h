// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The bricks of a SampledWall as plain data, for code that asks many points at once.
///
/// This header must not pull in templates of other libraries (see instruction_set.h).
#pragma once

#include <cstdint>

namespace packmesh {

class SampledWall;

/// Bricks of cells between nodes, in each of which the distance is interpolated.
struct BrickView {
  static constexpr int cells = 8;         ///< along the edge of a brick
  static constexpr int row = cells + 1;   ///< nodes along it, those on its faces included
  static constexpr int slab = row * row;  ///< nodes of a face
  static constexpr int nodes = slab * row;

  /// Distances are stored in this many steps per spacing, and are cut off where these no longer fit: so that
  /// what is needed again and again stays near the processor.
  static constexpr int stepsPerSpacing = 1024;

  /// Where brick (i,j,k) begins in `values`, at i + bricks[0] * (j + bricks[1] * k); negative while it is not
  /// known.
  const std::int32_t* begins;
  /// The distances at the nodes of bricks, x fastest. Where they are changes as bricks become known. After
  /// the last there is one value more.
  const std::int16_t* const* values;
  int bricks[3];
  float nodesPerLength;  ///< [1/µm]
  const SampledWall* wall;

  /// Makes a brick known.
  void (*evaluate)(const SampledWall& wall, int index);
};

}  // namespace packmesh
