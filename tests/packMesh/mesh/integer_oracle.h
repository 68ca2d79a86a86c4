// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Slow exact geometry on integers, independent of the library: what predicates are tested against.
#pragma once

#include <array>
#include <vector>

namespace packmesh::test {

__extension__ typedef __int128 Wide;
using IntegerPoint = std::array<long, 3>;
using WideVector = std::array<Wide, 3>;

inline int sign(Wide x) {
  return (x > 0) - (x < 0);
}

inline WideVector minus(const WideVector& a, const WideVector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline WideVector cross(const WideVector& a, const WideVector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Wide dot(const WideVector& a, const WideVector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline bool isZero(const WideVector& a) {
  return a == WideVector{0, 0, 0};
}
inline WideVector widen(const IntegerPoint& p) {
  return {p[0], p[1], p[2]};
}

/// Six times the volume of a tetrahedron, positive where (b-a)x(c-a) points to p.
inline Wide volume(const IntegerPoint& a, const IntegerPoint& b, const IntegerPoint& c,
                   const IntegerPoint& p) {
  return dot(cross(minus(widen(b), widen(a)), minus(widen(c), widen(a))), minus(widen(p), widen(a)));
}

/// Whether the origin lies in the convex hull of `points`: by Caratheodory's theorem it then lies in a point,
/// a segment, a triangle or a tetrahedron of them. Coordinates below 2^26.
inline bool hullContainsOrigin(const std::vector<WideVector>& points) {
  const std::size_t n = points.size();
  for (std::size_t i = 0; i < n; ++i) {
    const WideVector& a = points[i];
    if (isZero(a)) return true;
    for (std::size_t j = i + 1; j < n; ++j) {
      const WideVector& b = points[j];
      const WideVector ab = cross(a, b);
      if (isZero(ab) && dot(a, b) <= 0) return true;
      for (std::size_t k = j + 1; k < n; ++k) {
        const WideVector& c = points[k];
        const WideVector bc = cross(b, c), ca = cross(c, a), normal = cross(minus(b, a), minus(c, a));
        const Wide height = dot(a, bc);
        if (height == 0) {
          if (!isZero(normal) && dot(normal, ab) >= 0 && dot(normal, bc) >= 0 && dot(normal, ca) >= 0)
            return true;
          continue;
        }
        for (std::size_t l = k + 1; l < n; ++l) {
          // Signs of the four tetrahedra with the origin in place of one corner.
          const WideVector& d = points[l];
          const Wide whole = dot(cross(minus(b, a), minus(c, a)), minus(d, a));
          if (whole == 0) continue;
          const int s = sign(whole);
          const Wide withoutA = dot(d, bc), withoutB = dot(d, ca), withoutC = dot(d, ab);
          if (-height * s >= 0 && withoutA * s >= 0 && withoutB * s >= 0 && withoutC * s >= 0) return true;
        }
      }
    }
  }
  return false;
}

/// Whether two closed triangles, degenerate or not, have a common point: the origin is in the hull of their
/// differences.
inline bool trianglesMeet(const std::array<IntegerPoint, 3>& a, const std::array<IntegerPoint, 3>& b) {
  std::vector<WideVector> differences;
  for (const IntegerPoint& p : a)
    for (const IntegerPoint& q : b) differences.push_back(minus(widen(p), widen(q)));
  return hullContainsOrigin(differences);
}

}  // namespace packmesh::test
