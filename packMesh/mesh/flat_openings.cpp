// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/flat_openings.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "packMesh/core/error.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/core/vector_text.h"
#include "packMesh/mesh/polygon.h"
#include "packMesh/mesh/predicates.h"

namespace packmesh {
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
bool isStarShaped(const Polygon& polygon, const Eigen::Vector2d& center) {
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
