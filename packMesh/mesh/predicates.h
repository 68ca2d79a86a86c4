// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Exact signs of orientation determinants.
///
/// Method: J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric
/// predicates", Discrete & Computational Geometry 18 (1997). The filter (stage A) is defined here to be
/// inlined; the adaptive and exact stages are those of the TetGen library. TetGen's own front end is
/// deliberately bypassed: its static filter has a bound that belongs to TetGen's last input.
///
/// Exact unless an intermediate result over- or underflows: every coordinate must be zero or of magnitude
/// 1e-90 to 1e90. Must not be called while another thread runs TetGen (which has global state).
#pragma once

#include <cmath>

#include "packMesh/core/vector.h"

namespace packmesh {

namespace predicates {

/// Unit roundoff of double and the error bounds of the filtered determinants relative to their permanents
/// (Shewchuk 1997, figures 21 and 24).
inline constexpr double unitRoundoff = 1.1102230246251565e-16;
inline constexpr double errorBound2d = (3.0 + 16.0 * unitRoundoff) * unitRoundoff;
inline constexpr double errorBound3d = (7.0 + 56.0 * unitRoundoff) * unitRoundoff;

/// The adaptive stages: sign of the determinant if the filter is inconclusive.
int exactSideOfPlane(const double* a, const double* b, const double* c, const double* p, double permanent);
int exactTurn(const double* a, const double* b, const double* p, double permanent);

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
  const double bound = predicates::errorBound3d * permanent;
  if (determinant > bound) return -1;
  if (-determinant > bound) return 1;
  return predicates::exactSideOfPlane(a.data(), b.data(), c.data(), p.data(), permanent);
}

/// Exact sign of the turn a -> b -> p in the plane: +1 left (counter-clockwise), -1 right, 0 collinear.
inline int turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p) {
  const double left = (a[0] - p[0]) * (b[1] - p[1]), right = (a[1] - p[1]) * (b[0] - p[0]);
  const double determinant = left - right;
  const double permanent = std::abs(left) + std::abs(right);
  const double bound = predicates::errorBound2d * permanent;
  if (determinant > bound) return 1;
  if (-determinant > bound) return -1;
  return predicates::exactTurn(a.data(), b.data(), p.data(), permanent);
}

/// Exact turn of a, b, c projected along axis `drop`.
inline int turnSeen(int drop, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto seen = [&](const Vec3& p) { return Eigen::Vector2d(p[(drop + 1) % 3], p[(drop + 2) % 3]); };
  return turn(seen(a), seen(b), seen(c));
}

/// An axis along which triangle a, b, c projects to a triangle; -1 if it has no area. Exact.
inline int axisShowing(const Vec3& a, const Vec3& b, const Vec3& c) {
  for (int axis = 0; axis < 3; ++axis)
    if (turnSeen(axis, a, b, c) != 0) return axis;
  return -1;
}

}  // namespace packmesh
