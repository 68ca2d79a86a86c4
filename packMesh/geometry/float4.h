// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Four floats at a time, the same on every processor (GCC and Clang vector extension).
#pragma once

namespace packmesh {

using Float4 = float __attribute__((vector_size(16)));
using Int4 = int __attribute__((vector_size(16)));

inline Float4 splat(float x) {
  return Float4{x, x, x, x};
}
inline Float4 abs(Float4 x) {
  return (Float4)((Int4)x & 0x7fffffff);
}
inline Float4 max(Float4 a, Float4 b) {
  return a > b ? a : b;
}
inline Float4 min(Float4 a, Float4 b) {
  return a < b ? a : b;
}

/// Scalar product; each operand three floats or three Float4.
template <class A, class B>
inline Float4 dot(const A* a, const B* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

}  // namespace packmesh
