// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/polygon.h"

#include <algorithm>
#include <map>
#include <utility>

#include "packMesh/core/error.h"
#include "packMesh/mesh/predicates.h"

namespace packmesh {
namespace {

using Vector2 = Eigen::Vector2d;
using Key = std::pair<double, double>;

Key keyOf(const Vector2& p) {
  return {p.x(), p.y()};
}

/// True if p is inside or on the border of a counter-clockwise triangle.
bool inTriangle(const Vector2& a, const Vector2& b, const Vector2& c, const Vector2& p) {
  return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
}

}  // namespace

double twiceArea(const Polygon& polygon) {
  double sum = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    sum += (a.x() - polygon[0].x()) * (b.y() - polygon[0].y()) -
           (a.y() - polygon[0].y()) * (b.x() - polygon[0].x());
  }
  return sum;
}

bool contains(const Polygon& polygon, const Vector2& point) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2 *a = &polygon[i], *b = &polygon[(i + 1) % polygon.size()];
    if ((a->y() <= point.y()) == (b->y() <= point.y())) continue;
    if (a->y() > b->y()) std::swap(a, b);
    if (turn(*a, *b, point) > 0) inside = !inside;
  }
  return inside;
}

std::vector<Polygon> loopsOf(const std::vector<std::array<Vector2, 2>>& segments) {
  std::map<Key, std::vector<std::size_t>> at;
  std::vector<char> used(segments.size(), 0);
  for (std::size_t s = 0; s < segments.size(); ++s) {
    used[s] = segments[s][0] == segments[s][1];
    if (used[s]) continue;
    for (const Vector2& end : segments[s]) at[keyOf(end)].push_back(s);
  }
  std::vector<Polygon> loops;
  for (std::size_t first = 0; first < segments.size(); ++first) {
    if (used[first]) continue;
    Polygon loop;
    Vector2 end = segments[first][0];
    std::size_t s = first;
    while (!used[s]) {
      used[s] = 1;
      loop.push_back(end);
      end = keyOf(segments[s][0]) == keyOf(end) ? segments[s][1] : segments[s][0];
      for (const std::size_t next : at[keyOf(end)])
        if (!used[next]) {
          s = next;
          break;
        }
    }
    if (keyOf(end) != keyOf(loop.front())) throw MeshError("a cross-section is not closed");
    if (loop.size() < 3) continue;
    if (twiceArea(loop) < 0.0) std::reverse(loop.begin(), loop.end());
    loops.push_back(std::move(loop));
  }
  if (loops.empty()) throw MeshError("the cross-section is empty");
  for (const Polygon& outer : loops)
    for (const Polygon& inner : loops)
      if (&outer != &inner && contains(outer, inner.front())) throw MeshError("a cross-section has a hole");
  return loops;
}

std::vector<Triangle> triangulated(const Polygon& polygon) {
  std::vector<int> left;
  for (int i = 0; i < static_cast<int>(polygon.size()); ++i) left.push_back(i);
  std::vector<Triangle> triangles;
  while (left.size() > 3) {
    bool cut = false;
    for (std::size_t i = 0; i < left.size() && !cut; ++i) {
      const std::size_t n = left.size();
      const int before = left[(i + n - 1) % n], here = left[i], after = left[(i + 1) % n];
      const int bend = turn(polygon[before], polygon[here], polygon[after]);
      if (bend < 0) continue;
      bool ear = true;
      for (const int other : left)
        ear = ear && (other == before || other == here || other == after || bend == 0 ||
                      !inTriangle(polygon[before], polygon[here], polygon[after], polygon[other]));
      if (!ear || (bend == 0 && n > 3 && turn(polygon[here], polygon[after], polygon[before]) != 0)) continue;
      triangles.push_back({before, here, after});
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
      cut = true;
    }
    if (!cut) throw MeshError("a cross-section is clockwise or intersects itself");
  }
  triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

TriangleMesh prismOver(const Polygon& polygon, int axis, double lo, double hi) {
  TriangleMesh prism;
  const int n = static_cast<int>(polygon.size()), u = (axis + 1) % 3, v = (axis + 2) % 3;
  for (const double end : {lo, hi})
    for (const Vector2& p : polygon) {
      Vec3 vertex;
      vertex[axis] = end;
      vertex[u] = p.x();
      vertex[v] = p.y();
      prism.vertices.push_back(vertex);
    }
  for (const Triangle& t : triangulated(polygon)) {
    prism.triangles.push_back({t[0], t[2], t[1]});
    prism.triangles.push_back({n + t[0], n + t[1], n + t[2]});
  }
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    prism.triangles.push_back({i, j, n + j});
    prism.triangles.push_back({i, n + j, n + i});
  }
  return prism;
}

}  // namespace packmesh
