// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Nearest point of one triangle. Internal to packMesh/mesh and packMesh/field.
#pragma once

#include "packMesh/core/vector.h"

namespace packmesh {

/// A triangle a, a + u, a + v with the products needed to compute nearest points.
struct Facet {
  Vec3 a, u, v;
  double uu, uv, vv;

  Facet(const Vec3& first, const Vec3& second, const Vec3& third)
      : a(first), u(second - first), v(third - first), uu(u.dot(u)), uv(u.dot(v)), vv(v.dot(v)) {}

  struct Nearest {
    double s, t;  ///< the point is a + s u + t v
    int feature;  ///< corner 0-2, edge 3-5 (from corner f-3 to the next), face 6
  };

  Vec3 at(const Nearest& nearest) const { return a + nearest.s * u + nearest.t * v; }

  /// Minimises |s u + t v - (p - a)|² over the triangle s, t >= 0, s + t <= 1: the unconstrained minimum if
  /// it is inside, otherwise the best minimum on the three edges.
  Nearest nearest(const Vec3& p) const;
};

inline Facet::Nearest Facet::nearest(const Vec3& p) const {
  const Vec3 w = p - a;
  const double uw = u.dot(w), vw = v.dot(w);
  const double determinant = uu * vv - uv * uv;
  const double s = vv * uw - uv * vw, t = uu * vw - uv * uw;
  if (s > 0.0 && t > 0.0 && s + t < determinant) return {s / determinant, t / determinant, 6};

  // Position along each edge, and the squared distance there minus |w|².
  Nearest best{0.0, 0.0, 0};
  double lowest = 0.0;
  const auto consider = [&](double x, double y, int feature) {
    const double value = x * x * uu + 2.0 * x * y * uv + y * y * vv - 2.0 * (x * uw + y * vw);
    if (value < lowest) {
      lowest = value;
      best = {x, y, feature};
    }
  };
  const double onU = uw / uu, onV = vw / vv;
  if (onU >= 1.0)
    consider(1.0, 0.0, 1);
  else if (onU > 0.0)
    consider(onU, 0.0, 3);
  if (onV >= 1.0)
    consider(0.0, 1.0, 2);
  else if (onV > 0.0)
    consider(0.0, onV, 5);
  // From corner u to corner v.
  const double across = (uu - uv + vw - uw) / (uu - 2.0 * uv + vv);
  if (across > 0.0 && across < 1.0) consider(1.0 - across, across, 4);
  return best;
}

}  // namespace packmesh
