// SPDX-License-Identifier: AGPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "packMesh/core/poll.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/mesh_repair.h"
#include "packMesh/mesh/predicates.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/mesh/union_find.h"

namespace packmesh {
namespace {

/// A triangle by its corners.
struct Corners {
  std::array<int, 3> sorted;
  bool even;  ///< in the order of the sorted ones, or a rotation of it
  int triangle;

  bool operator<(const Corners& other) const {
    return std::tie(sorted, triangle) < std::tie(other.sorted, other.triangle);
  }
};

Corners cornersOf(const TriangleMesh& mesh, int t) {
  const Triangle& corner = mesh.triangles[t];
  Corners corners{{corner[0], corner[1], corner[2]}, true, t};
  std::sort(corners.sorted.begin(), corners.sorted.end());
  for (int k = 0; k < 3; ++k)
    if (corner[k] == corners.sorted[0]) corners.even = corner[(k + 1) % 3] == corners.sorted[1];
  return corners;
}

bool hasOpenEdges(const TriangleMesh& mesh) {
  const std::vector<TriangleSide> sides = sortedSides(mesh);
  for (std::size_t from = 0, to = 0; from < sides.size(); from = to) {
    for (to = from; to < sides.size() && sides[to].sameEdge(sides[from]);) ++to;
    if (to - from == 1) return true;
  }
  return false;
}

TriangleMesh without(const TriangleMesh& mesh, const std::vector<char>& removed) {
  TriangleMesh rest;
  rest.vertices = mesh.vertices;
  for (std::size_t t = 0; t < removed.size(); ++t)
    if (!removed[t]) rest.triangles.push_back(mesh.triangles[t]);
  return rest;
}

}  // namespace

std::size_t removeCoincident(TriangleMesh& mesh) {
  std::vector<Corners> all;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) all.push_back(cornersOf(mesh, int(t)));
  std::sort(all.begin(), all.end());
  std::vector<char> cancelled(all.size(), false), repeated(all.size(), false);
  bool any = false;
  for (std::size_t from = 0, to = 0; from < all.size(); from = to) {
    int balance = 0;
    for (to = from; to < all.size() && all[to].sorted == all[from].sorted; ++to)
      balance += all[to].even ? 1 : -1;
    if (to - from == 1) continue;
    any = true;
    bool kept = balance == 0;  // none is
    for (std::size_t i = from; i < to; ++i) {
      repeated[all[i].triangle] = i > from;
      const bool keeps = !kept && all[i].even == (balance > 0);
      cancelled[all[i].triangle] = !keeps;
      kept = kept || keeps;
    }
  }
  if (!any) return 0;
  TriangleMesh rest = without(mesh, cancelled);
  if (rest.triangles.empty() || (hasOpenEdges(rest) && !hasOpenEdges(without(mesh, repeated))))
    rest = without(mesh, repeated);
  const std::size_t removed = mesh.triangles.size() - rest.triangles.size();
  mesh = std::move(rest);
  return removed;
}

namespace {

/// Flips per flat triangle: a flip next to a triangle that is not flat removes one; flips between flat ones
/// only shorten their longest sides, and take place where many corners lie on one line. Random triangulations
/// of 10^4 collinear corners need 20.
constexpr std::size_t flipsPerTriangle = 200;

std::uint64_t keyOf(int a, int b) {
  return std::uint64_t(static_cast<std::uint32_t>(a)) << 32 | static_cast<std::uint32_t>(b);
}

/// Sides of all triangles, by directed edge.
class SideTable {
 public:
  explicit SideTable(const TriangleMesh& mesh) {
    triangleOf_.reserve(3 * mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) add(mesh.triangles[t], static_cast<int>(t));
  }

  void add(const Triangle& t, int number) {
    for (int k = 0; k < 3; ++k) triangleOf_[keyOf(t[k], t[(k + 1) % 3])] = number;
  }
  void remove(const Triangle& t) {
    for (int k = 0; k < 3; ++k) triangleOf_.erase(keyOf(t[k], t[(k + 1) % 3]));
  }
  /// The triangle with an edge from a to b, -1 if there is none.
  int find(int a, int b) const {
    const auto found = triangleOf_.find(keyOf(a, b));
    return found == triangleOf_.end() ? -1 : found->second;
  }

 private:
  std::unordered_map<std::uint64_t, int> triangleOf_;
};

/// The corner opposite the longest side of a triangle without area; it lies between the other two.
int middleCorner(const TriangleMesh& mesh, int t) {
  int middle = 0;
  double longest = -1.0;
  for (int k = 0; k < 3; ++k) {
    const double side = (mesh.corner(t, (k + 2) % 3) - mesh.corner(t, (k + 1) % 3)).squaredNorm();
    if (side > longest) {
      longest = side;
      middle = k;
    }
  }
  return middle;
}

bool isFlat(const TriangleMesh& mesh, int t, double flatness) {
  if (axisShowing(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)) < 0) return true;
  if (flatness == 0.0) return false;
  const int k = middleCorner(mesh, t);
  const Vec3 side = mesh.corner(t, (k + 2) % 3) - mesh.corner(t, (k + 1) % 3);
  const Vec3 across = side.cross(mesh.corner(t, k) - mesh.corner(t, (k + 1) % 3));
  return across.norm() <= flatness * side.squaredNorm();
}

/// Flips in rounds: each tries the triangles that are flat at its beginning, in ascending order. A triangle
/// is tried again only when something has changed that decides whether it can be flipped: it, a neighbour, or
/// the edge that would be created twice.
class Flattening {
 public:
  Flattening(TriangleMesh& mesh, double flatness, std::vector<int> flat)
      : mesh_(mesh), flatness_(flatness), sides_(mesh), listed_(mesh.triangles.size(), 0) {
    for (const int t : flat) {
      listed_[t] = 1;
      next_.insert(next_.end(), t);
      stuck_.insert(stuck_.end(), t);
    }
  }

  void operator()(std::size_t mostFlips) {
    while (flips_ < mostFlips && !stuck_.empty()) {
      const std::size_t before = flips_;
      round();
      relist();
      if (flips_ == before && !flipOfTwoFlat()) return;
    }
  }

 private:
  bool flat(int t) const { return isFlat(mesh_, t, flatness_); }

  void round() {
    now_ = std::exchange(next_, {});
    while (!now_.empty()) {
      current_ = *now_.begin();
      now_.erase(now_.begin());
      pollAt(steps_++);
      if (flat(current_)) flip(current_, false);
    }
    current_ = -1;
  }

  /// The first one for which that is possible. @return false if there is none
  bool flipOfTwoFlat() {
    while (!stuck_.empty()) {
      const int t = *stuck_.begin();
      pollAt(steps_++);
      if (flat(t) && flip(t, true)) return true;
      stuck_.erase(t);
    }
    return false;
  }

  /// Flips the longest side of a flat triangle t. @return false if that is not possible
  /// @param flatToo flip even if the triangle on the other side is flat
  bool flip(int t, bool flatToo) {
    const int k = middleCorner(mesh_, t);
    const Triangle given = mesh_.triangles[t];
    const int b = given[k], c = given[(k + 1) % 3], a = given[(k + 2) % 3];  // the side runs from c to a
    const int beyond = sides_.find(a, c);
    if (beyond < 0 || (!flatToo && flat(beyond))) return false;
    const Triangle other = mesh_.triangles[beyond];
    int d = -1;
    for (const int v : other)
      if (v != a && v != c) d = v;
    if (d == b) return false;
    if (sides_.find(b, d) >= 0 || sides_.find(d, b) >= 0) {
      waiting_[keyOf(std::min(b, d), std::max(b, d))].push_back(t);
      return false;
    }
    sides_.remove(given);
    sides_.remove(other);
    mesh_.triangles[t] = {a, b, d};
    mesh_.triangles[beyond] = {b, c, d};
    sides_.add(mesh_.triangles[t], t);
    sides_.add(mesh_.triangles[beyond], beyond);
    ++flips_;
    for (const int changed : {t, beyond}) {
      changed_.push_back(changed);
      tryAgain(changed);
      const Triangle corners = mesh_.triangles[changed];
      for (int e = 0; e < 3; ++e)
        if (const int neighbour = sides_.find(corners[(e + 1) % 3], corners[e]); neighbour >= 0)
          tryAgain(neighbour);
    }
    if (const auto found = waiting_.find(keyOf(std::min(a, c), std::max(a, c))); found != waiting_.end()) {
      for (const int blocked : std::exchange(found->second, {})) tryAgain(blocked);
    }
    return true;
  }

  void tryAgain(int t) {
    if (!flat(t)) return;
    stuck_.insert(t);
    (listed_[t] && t > current_ && current_ >= 0 ? now_ : next_).insert(t);
  }

  void relist() {
    for (const int t : std::exchange(changed_, {})) listed_[t] = flat(t);
  }

  TriangleMesh& mesh_;
  double flatness_;
  SideTable sides_;
  std::vector<char> listed_;  ///< flat at the beginning of the round
  std::set<int> now_, next_;  ///< to be tried in this round and in the next one
  std::set<int> stuck_;       ///< to be flipped next to a flat one if nothing else is possible
  std::vector<int> changed_;  ///< in this round
  std::unordered_map<std::uint64_t, std::vector<int>> waiting_;  ///< by the edge that prevents a flip
  int current_ = -1;  ///< the triangle that is being tried in a round
  std::size_t flips_ = 0, steps_ = 0;
};

std::vector<int> flatTriangles(const TriangleMesh& mesh, double flatness) {
  std::vector<int> flat;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    pollAt(t);
    if (isFlat(mesh, static_cast<int>(t), flatness)) flat.push_back(static_cast<int>(t));
  }
  return flat;
}

}  // namespace

std::size_t removeFlatTriangles(TriangleMesh& mesh, double flatness) {
  const std::vector<int> flat = flatTriangles(mesh, flatness);
  const std::size_t given = flat.size();
  if (given == 0 || given == mesh.triangles.size())
    return 0;  // with none that is not flat, flips are in vain
  Flattening(mesh, flatness, flat)(flipsPerTriangle * given);
  return given - std::min(given, flatTriangles(mesh, flatness).size());
}

namespace {

constexpr double fullTurn = 6.283185307179586;

/// Edge from corner `k` of a triangle to the next one.
struct HalfEdge {
  int from, to, triangle, k;
};

bool before(const HalfEdge& a, const HalfEdge& b) {
  return a.from != b.from ? a.from < b.from : a.to != b.to ? a.to < b.to : a.triangle < b.triangle;
}

/// Angle from triangle a to triangle b through the inside, about their common edge [rad].
double turnThroughInside(const TriangleMesh& mesh, const HalfEdge& a, const HalfEdge& b) {
  const Vec3& origin = mesh.vertices[a.from];
  const Vec3 axis = (mesh.vertices[a.to] - origin).normalized();
  const Vec3 first = mesh.corner(a.triangle, (a.k + 2) % 3) - origin;
  const Vec3 second = mesh.corner(b.triangle, (b.k + 2) % 3) - origin;
  // Seen along the axis, the inside of an outward-oriented triangle is clockwise of it.
  const Vec3 across = axis.cross(first);
  const double angle = std::atan2(-second.dot(across), second.dot(first - axis.dot(first) * axis));
  return angle > 0.0 ? angle : angle + fullTurn;
}

}  // namespace

TriangleMesh separateTouchingParts(const TriangleMesh& mesh) {
  const int corners = 3 * static_cast<int>(mesh.triangles.size());
  std::vector<HalfEdge> edges;
  for (int c = 0; c < corners; ++c)
    edges.push_back({mesh.triangles[c / 3][c % 3], mesh.triangles[c / 3][(c % 3 + 1) % 3], c / 3, c % 3});
  std::sort(edges.begin(), edges.end(), before);

  // Corners of triangles that share one vertex of the result.
  UnionFind sets(corners);
  for (const HalfEdge& edge : edges) {
    auto other = std::lower_bound(edges.begin(), edges.end(), HalfEdge{edge.to, edge.from, -1, 0}, before);
    const auto begin = other;
    double least = 2.0 * fullTurn;
    for (auto at = begin; at != edges.end() && at->from == edge.to && at->to == edge.from; ++at) {
      const bool single =
          at == begin && (at + 1 == edges.end() || (at + 1)->from != edge.to || (at + 1)->to != edge.from);
      const double turn = single ? 0.0 : turnThroughInside(mesh, edge, *at);
      if (turn < least) {
        least = turn;
        other = at;
      }
    }
    if (least > fullTurn) continue;  // open
    sets.join(3 * edge.triangle + edge.k, 3 * other->triangle + (other->k + 1) % 3);
    sets.join(3 * edge.triangle + (edge.k + 1) % 3, 3 * other->triangle + other->k);
  }

  TriangleMesh result;
  std::vector<int> number(corners, -1);
  for (int c = 0; c < corners; ++c) {
    const int first = sets.first(c);
    if (number[first] < 0) {
      number[first] = static_cast<int>(result.vertices.size());
      result.vertices.push_back(mesh.vertices[mesh.triangles[c / 3][c % 3]]);
    }
    number[c] = number[first];
  }
  for (int t = 0; t < corners; t += 3) result.triangles.push_back({number[t], number[t + 1], number[t + 2]});
  return result;
}

std::size_t moveTouchingPartsApart(TriangleMesh& mesh) {
  TriangleMesh parts = separateTouchingParts(mesh);
  std::vector<Vec3> distinct = parts.vertices;
  const std::vector<int> place = mergeEqualVertices(distinct);
  if (distinct.size() == parts.vertices.size()) return 0;
  std::vector<int> copies(distinct.size(), 0);
  for (const int p : place) ++copies[p];
  // Every neighbour of a vertex follows it in one triangle.
  std::vector<Vec3> sum(parts.vertices.size(), Vec3::Zero());
  std::vector<int> neighbours(parts.vertices.size(), 0);
  for (const Triangle& t : parts.triangles)
    for (int k = 0; k < 3; ++k) {
      sum[t[k]] += parts.vertices[t[(k + 1) % 3]];
      ++neighbours[t[k]];
    }
  for (std::size_t v = 0; v < place.size(); ++v)
    if (copies[place[v]] > 1) {
      Vec3& at = parts.vertices[v];
      at += tolerance::touchingFraction * (sum[v] / neighbours[v] - at);
    }
  mesh = std::move(parts);
  return static_cast<std::size_t>(
      std::count_if(copies.begin(), copies.end(), [](int count) { return count > 1; }));
}

}  // namespace packmesh
