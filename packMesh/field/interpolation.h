// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Trilinear interpolation, the only one, and the bricks that it reads: for doubles, and for the lanes
/// of kernels.
///
/// This header must not pull in templates of other libraries (see instruction_set.h).
#pragma once

#include <cstdint>

namespace packmesh {

/// Value and derivatives at a point in a grid cell, from the values at its corners.
/// @tparam Real double, or lanes of floats: the same operations in the same order
template <class Real>
struct Trilinear {
  Real value;
  Real slope[3];  ///< derivatives of the value along the axes [per cell]

  /// @param c corner i + 2j + 4k is at (i,j,k)
  /// @param t position of the point in the cell, 0 to 1 along each axis
  __attribute__((always_inline)) Trilinear(const Real (&c)[8], const Real (&t)[3]) {
    const Real y0z0 = mix(c[0], c[1], t[0]), y1z0 = mix(c[2], c[3], t[0]);
    const Real y0z1 = mix(c[4], c[5], t[0]), y1z1 = mix(c[6], c[7], t[0]);
    const Real z0 = mix(y0z0, y1z0, t[1]), z1 = mix(y0z1, y1z1, t[1]);
    value = mix(z0, z1, t[2]);
    slope[0] = mix(mix(c[1] - c[0], c[3] - c[2], t[1]), mix(c[5] - c[4], c[7] - c[6], t[1]), t[2]);
    slope[1] = mix(y1z0 - y0z0, y1z1 - y0z1, t[2]);
    slope[2] = z1 - z0;
  }

 private:
  __attribute__((always_inline)) static Real mix(const Real& a, const Real& b, const Real& t) {
    return a + (b - a) * t;
  }
};

// This header must not pull in templates of other libraries (see instruction_set.h).

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
