// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Exact signs of orientation determinants.
///
/// Adaptive: a floating-point determinant with a bound of its error (after J. R. Shewchuk, "Adaptive
/// precision floating-point arithmetic and fast robust geometric predicates", Discrete & Computational
/// Geometry 18 (1997), doi 10.1007/PL00009321), and where its sign is not certain, integers of sufficient
/// length.
///
/// Exact for all coordinates of magnitude up to 1e90, however small or different. (Mesh files may have
/// tolerance::largestCoordinate; beyond 1e90, underflow is not covered by the bound below.) Pure functions:
/// safe from any thread. Rounding to nearest is assumed; contraction to fused multiply-add, which the build
/// excludes, would only leave out roundings.
#pragma once

#include <cmath>

#include "packMesh/core/vector.h"

namespace packmesh {

namespace predicates {

/// Unit roundoff of double.
inline constexpr double u = 1.1102230246251565e-16;

/// Bounds of the error of the determinants below relative to their permanents, the sums of the magnitudes of
/// all products. Differences, products and sums are each rounded by a factor 1 + d, |d| <= u. In three
/// dimensions a product az (bx cy) of differences has three factors from these, two from the multiplications
/// and one each from the subtraction of another such product and from the addition of two of the three terms:
/// error <= 7u / (1 - 7u) permanent. The last addition does not change the sign of the sum. In two dimensions
/// there are two factors from differences and one from the multiplication; the subtraction is the last.
///
/// The terms in u^2 cover that permanent and bound are rounded themselves, by at most twelve factors 1 + d.
inline constexpr double errorBound3d = (7.0 + 256.0 * u) * u;
inline constexpr double errorBound2d = (3.0 + 64.0 * u) * u;

/// Bound of the error by underflow. Differences are exact where they are subnormal; each of the six products
/// of two loses up to 2^-1075, which is multiplied by differences of up to 2^300 (1e90 is below 2^299), and
/// each of the three products of three up to 2^-1075 again.
inline constexpr double underflow = 0x1p-770;

/// The signs if the floating-point determinant is inconclusive.
int exactSideOfPlane(const double* a, const double* b, const double* c, const double* p);
int exactTurn(const double* a, const double* b, const double* p);

}  // namespace predicates

/// Side of the plane through a, b, c on which p lies, exactly: +1 where (b-a)x(c-a) points to (seen from
/// there a, b, c are counter-clockwise; the outside, for a triangle of an outward-oriented mesh), -1 on the
/// other side, 0 in the plane (always if a, b, c are collinear).
inline int sideOfPlane(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const double apx = a[0] - p[0], apy = a[1] - p[1], apz = a[2] - p[2];
  const double bpx = b[0] - p[0], bpy = b[1] - p[1], bpz = b[2] - p[2];
  const double cpx = c[0] - p[0], cpy = c[1] - p[1], cpz = c[2] - p[2];
  const double bc = bpx * cpy, cb = cpx * bpy, ca = cpx * apy, ac = apx * cpy, ab = apx * bpy, ba = bpx * apy;
  const double determinant = apz * (bc - cb) + bpz * (ca - ac) + cpz * (ab - ba);
  const double permanent = (std::abs(bc) + std::abs(cb)) * std::abs(apz) +
                           (std::abs(ca) + std::abs(ac)) * std::abs(bpz) +
                           (std::abs(ab) + std::abs(ba)) * std::abs(cpz);
  const double bound = predicates::errorBound3d * permanent + predicates::underflow;
  if (std::abs(determinant) > bound) return determinant > 0.0 ? -1 : 1;
  return predicates::exactSideOfPlane(a.data(), b.data(), c.data(), p.data());
}

/// Exact sign of the turn a -> b -> p in the plane: +1 left (counter-clockwise), -1 right, 0 collinear.
inline int turn(const Vec2& a, const Vec2& b, const Vec2& p) {
  const double left = (a[0] - p[0]) * (b[1] - p[1]), right = (a[1] - p[1]) * (b[0] - p[0]);
  const double determinant = left - right;
  const double permanent = std::abs(left) + std::abs(right);
  const double bound = predicates::errorBound2d * permanent + predicates::underflow;
  if (std::abs(determinant) > bound) return determinant > 0.0 ? 1 : -1;
  return predicates::exactTurn(a.data(), b.data(), p.data());
}

/// Exact turn of a, b, c projected along axis `drop`.
inline int turnSeen(int drop, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto seen = [&](const Vec3& p) { return Vec2(p[(drop + 1) % 3], p[(drop + 2) % 3]); };
  return turn(seen(a), seen(b), seen(c));
}

/// An axis along which triangle a, b, c projects to a triangle; -1 if it has no area. Exact.
inline int axisShowing(const Vec3& a, const Vec3& b, const Vec3& c) {
  for (int axis = 0; axis < 3; ++axis)
    if (turnSeen(axis, a, b, c) != 0) return axis;
  return -1;
}

}  // namespace packmesh
