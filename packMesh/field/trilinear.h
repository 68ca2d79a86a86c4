// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Trilinear interpolation, the only one: for doubles, and for the lanes of kernels.
///
/// This header must not pull in templates of other libraries (see instruction_set.h).
#pragma once

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

}  // namespace packmesh
