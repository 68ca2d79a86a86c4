// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/missing_triangles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "packMesh/mesh/sphere_grid.h"

namespace packmesh {
namespace {

Triangle sorted(int a, int b, int c) {
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  return {a, b, c};
}

/// Points are examined up to this many circumradii of a triangle from its circumcentre.
constexpr double looked = 3.0;

/// Whether some sphere through the corners of a triangle contains no point of the grid.
///
/// Centres of such spheres are o + s n, where o is the circumcentre of the triangle, R its circumradius and n
/// its normal; a point p is inside if q < 2 s h, with h = n·(p - o) and q = |p - o|² - R². So each point
/// bounds s from one side.
bool hasEmptySphere(const Triangle& corners, const std::vector<Vec3>& points, const SphereGrid& grid) {
  const Vec3 &a = points[corners[0]], u = points[corners[1]] - a, v = points[corners[2]] - a;
  const Vec3 normal = u.cross(v);
  const double twiceArea2 = normal.squaredNorm();
  if (!(twiceArea2 > 0.0)) return false;
  const Vec3 arm =
      (u.squaredNorm() * v.cross(normal) + v.squaredNorm() * normal.cross(u)) / (2.0 * twiceArea2);
  const Vec3 center = a + arm, n = normal / std::sqrt(twiceArea2);
  const double radius2 = arm.squaredNorm(), radius = std::sqrt(radius2);
  double least = -std::numeric_limits<double>::infinity(), most = -least;
  grid.forEachNear({center, looked * radius}, 0.0, [&](int p) {
    if (p == corners[0] || p == corners[1] || p == corners[2]) return;
    const Vec3 to = points[p] - center;
    const double h = n.dot(to), q = to.squaredNorm() - radius2;
    if (h > 0.0)
      most = std::min(most, 0.5 * q / h);
    else if (h < 0.0)
      least = std::max(least, 0.5 * q / h);
    else if (q < 0.0)
      most = -std::numeric_limits<double>::infinity();
  });
  if (!(least <= most)) return false;
  const double s = std::abs(std::clamp(0.0, least, most));
  return s + std::sqrt(radius2 + s * s) <= looked * radius;
}

}  // namespace

std::vector<int> likelyMissing(const std::vector<Triangle>& triangles, const std::vector<Vec3>& points) {
  std::vector<Sphere> dots;
  dots.reserve(points.size());
  for (const Vec3& p : points) dots.push_back({p, 0.0});
  const SphereGrid grid(dots);
  std::vector<int> missing;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (!hasEmptySphere(triangles[t], points, grid)) missing.push_back(static_cast<int>(t));
  return missing;
}

std::vector<int> missingTriangles(const std::vector<Triangle>& triangles,
                                  const std::vector<Tetrahedron>& tetrahedra, std::size_t points) {
  // Indexed by their lowest point; on average, a point is the lowest one of two triangles.
  std::vector<int> first(points + 1, 0);
  for (const Triangle& t : triangles) ++first[std::min({t[0], t[1], t[2]}) + 1];
  for (std::size_t p = 0; p < points; ++p) first[p + 1] += first[p];
  struct Entry {
    int middle, highest, triangle;
  };
  std::vector<Entry> entries(triangles.size());
  std::vector<int> next(first.begin(), first.end() - 1);
  for (std::size_t n = 0; n < triangles.size(); ++n) {
    const Triangle t = sorted(triangles[n][0], triangles[n][1], triangles[n][2]);
    entries[next[t[0]]++] = {t[1], t[2], static_cast<int>(n)};
  }
  std::vector<char> found(triangles.size(), 0);
  for (const Tetrahedron& t : tetrahedra)
    for (int k = 0; k < 4; ++k) {
      const Triangle face = sorted(t[(k + 1) & 3], t[(k + 2) & 3], t[(k + 3) & 3]);
      if (static_cast<std::size_t>(face[0]) >= points) continue;  // a new point
      for (int e = first[face[0]]; e < first[face[0] + 1]; ++e)
        if (entries[e].middle == face[1] && entries[e].highest == face[2]) found[entries[e].triangle] = 1;
    }
  std::vector<int> missing;
  for (std::size_t n = 0; n < found.size(); ++n)
    if (!found[n]) missing.push_back(static_cast<int>(n));
  return missing;
}

}  // namespace packmesh
