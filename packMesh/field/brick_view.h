// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The bricks of a SampledDistance as plain data, for code that asks many points at once.
///
/// This header must not pull in templates of other libraries (see instruction_set.h).
#pragma once

#include <cstdint>

namespace packmesh {

class SampledDistance;

/// Bricks of cells between nodes, in each of which the distance is interpolated.
struct BrickView {
  static constexpr int shift = 3;
  static constexpr int cells = 1 << shift;  ///< along the edge of a brick
  static constexpr int row = cells + 1;     ///< nodes along it, those on its faces included
  static constexpr int slab = row * row;    ///< nodes of a face
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
  const SampledDistance* sampled;

  /// Makes a brick known.
  void (*evaluate)(const SampledDistance& sampled, int index);

  /// The brick of the cell above a node.
  /// @tparam Int int, or lanes of it
  template <class Int>
  static Int brickOf(const Int (&node)[3], const int (&bricks)[3]) {
    return (node[0] >> shift) + bricks[0] * ((node[1] >> shift) + bricks[1] * (node[2] >> shift));
  }
  /// The node among those of that brick.
  template <class Int>
  static Int placeOf(const Int (&node)[3]) {
    constexpr int last = cells - 1;
    return (node[0] & last) + row * (node[1] & last) + slab * (node[2] & last);
  }
};

}  // namespace packmesh
