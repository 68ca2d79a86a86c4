// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The bricks of a SampledDistance as plain data, for code that evaluates many points at once.
///
/// This header must not pull in templates of other libraries (see instruction_set.h).
#pragma once

#include <cstdint>

namespace packmesh {

class SampledDistance;

/// Bricks of grid cells, in each of which the distance is interpolated.
struct BrickView {
  static constexpr int shift = 3;
  static constexpr int cells = 1 << shift;  ///< along the edge of a brick
  static constexpr int row = cells + 1;     ///< nodes along that edge, including those on its faces
  static constexpr int slab = row * row;    ///< nodes of a face
  static constexpr int nodes = slab * row;

  /// Distances are stored as integers in units of 1/stepsPerSpacing of the spacing, clipped to the range of
  /// the type: frequently used data then fit into the cache.
  static constexpr int stepsPerSpacing = 1024;

  /// Offset of brick (i,j,k) in `values`, at i + bricks[0] * (j + bricks[1] * k); negative until the brick is
  /// computed.
  const std::int32_t* begins;
  /// The distances at the nodes of bricks, x fastest. The address changes as bricks are added, by other
  /// threads too: read it after `begins`. After the last there is one more value.
  const std::int16_t* const* values;
  int bricks[3];
  float nodesPerLength;  ///< [1/µm]
  const SampledDistance* sampled;

  /// Computes a brick.
  void (*evaluate)(const SampledDistance& sampled, int index);

  /// The brick of the cell above a node.
  /// @tparam Int int, or lanes of it
  template <class Int>
  static Int brickOf(const Int (&node)[3], const int (&bricks)[3]) {
    return (node[0] >> shift) + bricks[0] * ((node[1] >> shift) + bricks[1] * (node[2] >> shift));
  }
  /// Index of the node within that brick.
  template <class Int>
  static Int placeOf(const Int (&node)[3]) {
    constexpr int last = cells - 1;
    return (node[0] & last) + row * (node[1] & last) + slab * (node[2] & last);
  }
};

}  // namespace packmesh
