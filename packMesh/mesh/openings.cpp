// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/openings.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "packMesh/core/error.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/core/vector.h"
#include "packMesh/mesh/predicates.h"

namespace packmesh {
namespace {

using Key = std::pair<double, double>;

Key keyOf(const Vec2& p) {
  return {p.x(), p.y()};
}

/// True if p is inside or on the border of a counter-clockwise triangle.
bool inTriangle(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& p) {
  return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
}

}  // namespace

double twiceArea(const Polygon& polygon) {
  double sum = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    sum += (a.x() - polygon[0].x()) * (b.y() - polygon[0].y()) -
           (a.y() - polygon[0].y()) * (b.x() - polygon[0].x());
  }
  return sum;
}

bool contains(const Polygon& polygon, const Vec2& point) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 *a = &polygon[i], *b = &polygon[(i + 1) % polygon.size()];
    if ((a->y() <= point.y()) == (b->y() <= point.y())) continue;
    if (a->y() > b->y()) std::swap(a, b);
    if (turn(*a, *b, point) > 0) inside = !inside;
  }
  return inside;
}

std::vector<Polygon> loopsOf(const std::vector<std::array<Vec2, 2>>& segments) {
  std::map<Key, std::vector<std::size_t>> at;
  std::vector<char> used(segments.size(), 0);
  for (std::size_t s = 0; s < segments.size(); ++s) {
    used[s] = segments[s][0] == segments[s][1];
    if (used[s]) continue;
    for (const Vec2& end : segments[s]) at[keyOf(end)].push_back(s);
  }
  std::vector<Polygon> loops;
  for (std::size_t first = 0; first < segments.size(); ++first) {
    if (used[first]) continue;
    Polygon loop;
    Vec2 end = segments[first][0];
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
    for (const Vec2& p : polygon) {
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

namespace {

/// More openings are holes in a damaged surface.
constexpr std::size_t mostOpenings = 100;

/// Outlines with more vertices that are not star-shaped are not closed: cutting ears has a quadratic cost.
constexpr std::size_t mostForEars = 3000;

struct Outline {
  std::vector<int> vertices;  ///< in the order in which a cap traverses them
  Vec3 center = Vec3::Zero(), normal = Vec3::Zero();
  double area = 0.0, length = 0.0;  ///< of the polygon, of its edges
  double deviation = 0.0;           ///< largest distance of a vertex from the plane
  int axis = 0;                     ///< along which it is projected
  Polygon polygon;                  ///< the projection, counter-clockwise
};

/// The open edges, as closed chains of vertices. @return what prevents that
std::string chains(const TriangleMesh& mesh, const std::vector<TriangleSide>& sides,
                   std::vector<std::vector<int>>& out) {
  std::map<int, std::vector<int>> ends;  // the neighbours along open edges; first, those that follow in a cap
  for (std::size_t from = 0, to = 0; from < sides.size(); from = to) {
    for (to = from; to < sides.size() && sides[to].sameEdge(sides[from]);) ++to;
    if (to - from != 1) continue;
    const TriangleSide& side = sides[from];
    const int a = side.forwards ? side.hi : side.lo, b = side.forwards ? side.lo : side.hi;
    ends[a].insert(ends[a].begin(), b);
    ends[b].push_back(a);
  }
  for (const auto& [vertex, neighbours] : ends)
    if (neighbours.size() != 2) return "several openings meet at " + toText(mesh.vertices[vertex]);
  while (!ends.empty()) {
    if (out.size() == mostOpenings) return "it has more than " + std::to_string(mostOpenings) + " openings";
    std::vector<int> chain;
    int at = ends.begin()->first, before = ends.begin()->second.back();
    for (auto found = ends.find(at); found != ends.end(); found = ends.find(at)) {
      chain.push_back(at);
      const std::vector<int>& next = found->second;
      const int following = next[0] != before ? next[0] : next[1];
      before = at;
      ends.erase(found);
      at = following;
    }
    out.push_back(std::move(chain));
  }
  return {};
}

Outline outlineOf(const TriangleMesh& mesh, std::vector<int> vertices) {
  Outline o;
  o.vertices = std::move(vertices);
  const auto at = [&](std::size_t i) -> const Vec3& {
    return mesh.vertices[o.vertices[i % o.vertices.size()]];
  };
  const Vec3 origin = at(0);
  Vec3 twice = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < o.vertices.size(); ++i) twice += (at(i) - origin).cross(at(i + 1) - origin);
  o.area = 0.5 * twice.norm();
  if (!(o.area > 0.0)) return o;
  o.normal = twice.normalized();
  Vec3 moment = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < o.vertices.size(); ++i) {
    const Vec3 a = at(i) - origin, b = at(i + 1) - origin;
    moment += a.cross(b).dot(o.normal) / (6.0 * o.area) * (a + b);
  }
  o.center = origin + moment;
  for (std::size_t i = 0; i < o.vertices.size(); ++i) o.length += (at(i + 1) - at(i)).norm();
  for (std::size_t i = 0; i < o.vertices.size(); ++i)
    o.deviation = std::max(o.deviation, std::abs(o.normal.dot(at(i) - o.center)));
  o.normal.cwiseAbs().maxCoeff(&o.axis);
  for (std::size_t i = 0; i < o.vertices.size(); ++i)
    o.polygon.push_back({at(i)[(o.axis + 1) % 3], at(i)[(o.axis + 2) % 3]});
  if (o.normal[o.axis] < 0.0) std::reverse(o.polygon.begin(), o.polygon.end());
  return o;
}

std::string placeOf(const TriangleMesh& mesh, const Outline& o) {
  const Vec3& at = o.area > 0.0 ? o.center : mesh.vertices[o.vertices[0]];
  return "the opening at " + toText(at) + " with " + std::to_string(o.vertices.size()) + " edges";
}

/// Why an outline cannot be closed; empty: it can.
std::string faultOf(const TriangleMesh& mesh, const Outline& o, double size, double flatness) {
  if (o.area < tolerance::crackFraction * size * o.length) return placeOf(mesh, o) + " is only a crack";
  if (o.deviation > flatness * size)
    return placeOf(mesh, o) + " is not flat: it deviates from a plane by " + toText(o.deviation, 3);
  return {};
}

/// Whether all triangles from `center` to the edges of a counter-clockwise polygon are counter-clockwise.
bool isStarShaped(const Polygon& polygon, const Vec2& center) {
  for (std::size_t i = 0; i < polygon.size(); ++i)
    if (turn(center, polygon[i], polygon[(i + 1) % polygon.size()]) <= 0) return false;
  return true;
}

std::string close(TriangleMesh& mesh, const Outline& o) {
  const int n = static_cast<int>(o.vertices.size());
  if (n > 3 && isStarShaped(o.polygon, {o.center[(o.axis + 1) % 3], o.center[(o.axis + 2) % 3]})) {
    const int center = static_cast<int>(mesh.vertices.size());
    mesh.vertices.push_back(o.center);
    for (int i = 0; i < n; ++i) mesh.triangles.push_back({center, o.vertices[i], o.vertices[(i + 1) % n]});
    return {};
  }
  if (o.vertices.size() > mostForEars) return placeOf(mesh, o) + " is not star-shaped and has too many edges";
  const bool reversed = o.normal[o.axis] < 0.0;
  const auto vertex = [&](int i) { return o.vertices[reversed ? n - 1 - i : i]; };
  try {
    for (const Triangle& t : triangulated(o.polygon))
      mesh.triangles.push_back({vertex(t[0]), vertex(t[reversed ? 2 : 1]), vertex(t[reversed ? 1 : 2])});
  } catch (const MeshError&) {
    return placeOf(mesh, o) + " has an outline that intersects itself";
  }
  return {};
}

/// Of two outlines in one plane, whether the second lies inside the first.
bool encloses(const Outline& outer, const Outline& inner, double thickness) {
  const double apart = std::abs(outer.normal.dot(inner.center - outer.center));
  return apart <= 2.0 * thickness && inner.axis == outer.axis &&
         contains(outer.polygon, inner.polygon.front());
}

}  // namespace

std::string capFlatOpenings(TriangleMesh& mesh, const std::vector<TriangleSide>& sides, double flatness,
                            std::vector<CappedOpening>& capped) {
  std::vector<std::vector<int>> all;
  if (const std::string fault = chains(mesh, sides, all); !fault.empty()) return fault;
  const double size = boundingBox(mesh).size().norm();
  std::vector<Outline> outlines;
  for (std::vector<int>& chain : all) {
    outlines.push_back(outlineOf(mesh, std::move(chain)));
    if (const std::string fault = faultOf(mesh, outlines.back(), size, flatness); !fault.empty())
      return fault;
  }
  for (const Outline& outer : outlines)
    for (const Outline& inner : outlines)
      if (&outer != &inner && encloses(outer, inner, flatness * size))
        return placeOf(mesh, outer) + " surrounds another one in the same plane";
  TriangleMesh closed = mesh;
  for (const Outline& o : outlines)
    if (const std::string fault = close(closed, o); !fault.empty()) return fault;
  for (const Outline& o : outlines)
    capped.push_back({o.center, o.area, o.vertices.size(),
                      o.deviation > tolerance::flatCapFraction * size ? o.deviation : 0.0});
  mesh = std::move(closed);
  return {};
}

}  // namespace packmesh
