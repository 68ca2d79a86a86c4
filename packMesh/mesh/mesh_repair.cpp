// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/mesh_repair.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>

#include "packMesh/core/error.h"
#include "packMesh/core/poll.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/core/vector.h"
#include "packMesh/mesh/mesh_tree.h"
#include "packMesh/mesh/predicates.h"
#include "packMesh/mesh/self_intersection.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/mesh/union_find.h"

namespace packmesh {
namespace {

std::string counted(std::size_t n, const std::string& one, const std::string& many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

/// Edges that do not belong to exactly two triangles.
struct EdgeFaults {
  std::size_t open = 0, crowded = 0;
  TriangleSide firstOpen{}, firstCrowded{};
  std::vector<int> openVertices;
};

EdgeFaults findEdgeFaults(const std::vector<TriangleSide>& sides) {
  EdgeFaults faults;
  for (std::size_t from = 0, to = 0; from < sides.size(); from = to) {
    for (to = from; to < sides.size() && sides[to].sameEdge(sides[from]);) ++to;
    if (to - from == 1) {
      if (faults.open++ == 0) faults.firstOpen = sides[from];
      faults.openVertices.insert(faults.openVertices.end(), {sides[from].lo, sides[from].hi});
    } else if (to - from > 2) {
      if (faults.crowded++ == 0) faults.firstCrowded = sides[from];
    }
  }
  return faults;
}

/// The edges of a mesh, and what is wrong with them.
struct Edges {
  std::vector<TriangleSide> sides;
  EdgeFaults faults;

  explicit Edges(const TriangleMesh& mesh) : sides(sortedSides(mesh)), faults(findEdgeFaults(sides)) {}
  /// None is open, but some have more than two triangles.
  bool areCrowded() const { return faults.open == 0 && faults.crowded > 0; }
};

std::size_t removeCollapsed(TriangleMesh& mesh) {
  const std::size_t before = mesh.triangles.size();
  mesh.triangles.erase(
      std::remove_if(mesh.triangles.begin(), mesh.triangles.end(),
                     [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }),
      mesh.triangles.end());
  return before - mesh.triangles.size();
}

/// Joins vertices on open edges that differ only by rounding, provided that this closes all open edges and
/// collapses no triangle. Returns the number of vertices joined.
/// @param openings edges other than those of cracks may stay open
std::size_t closeCracks(TriangleMesh& mesh, const EdgeFaults& faults, double medianEdge, bool openings) {
  std::vector<int> rim = faults.openVertices;
  std::sort(rim.begin(), rim.end());
  rim.erase(std::unique(rim.begin(), rim.end()), rim.end());
  std::vector<Vec3> points;
  for (const int v : rim) points.push_back(mesh.vertices[v]);
  const double reach = std::min(tolerance::crackFraction * boundingBox(mesh).size().norm(),
                                tolerance::crackEdgeFraction * medianEdge);
  const std::vector<int> first = firstOfNearVertices(points, reach);
  std::vector<int> target(mesh.vertices.size());
  std::iota(target.begin(), target.end(), 0);
  std::size_t joined = 0;
  for (std::size_t k = 0; k < rim.size(); ++k) {
    target[rim[k]] = rim[first[k]];
    joined += first[k] != static_cast<int>(k);
  }
  if (joined == 0) return 0;
  TriangleMesh closed = mesh;
  for (Triangle& t : closed.triangles)
    for (int& v : t) v = target[v];
  if (removeCollapsed(closed) > 0) return 0;
  const EdgeFaults left = findEdgeFaults(sortedSides(closed));
  if ((left.open > 0 && !openings) || left.crowded > 0) return 0;
  removeUnusedVertices(closed);
  mesh = std::move(closed);
  return joined;
}

/// Merges the vertices of edges so short that they are one by rounding (slivers of marching cubes, which
/// pinch the surface), and removes what that makes collapse or coincide, provided that every edge then has
/// two triangles. @return number of vertices merged
std::size_t mergeNear(TriangleMesh& mesh, double medianEdge) {
  const double reach = tolerance::nearFraction * medianEdge;
  UnionFind sets(mesh.vertices.size());
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      if ((mesh.vertices[a] - mesh.vertices[b]).norm() < reach) sets.join(a, b);
    }
  TriangleMesh merged = mesh;
  std::size_t joined = 0;
  for (int v = 0; v < static_cast<int>(mesh.vertices.size()); ++v) joined += sets.first(v) != v;
  if (joined == 0) return 0;
  for (Triangle& t : merged.triangles)
    for (int& v : t) v = sets.first(v);
  removeCollapsed(merged);
  removeCoincident(merged);
  const EdgeFaults left = findEdgeFaults(sortedSides(merged));
  if (merged.triangles.empty() || left.open > 0 || left.crowded > 0) return 0;
  removeUnusedVertices(merged);
  mesh = std::move(merged);
  return joined;
}

/// Statistics of edge lengths.
struct EdgeLengths {
  double median = 0.0;           ///< [µm]
  std::vector<double> shortest;  ///< shortest edge of each vertex [µm]
};

EdgeLengths edgeLengthsOf(const TriangleMesh& mesh) {
  std::vector<double> shortest(mesh.vertices.size(), std::numeric_limits<double>::infinity()), all;
  all.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      all.push_back((mesh.vertices[a] - mesh.vertices[b]).stableNorm());
      for (const int v : {a, b}) shortest[v] = std::min(shortest[v], all.back());
    }
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  return {*middle, std::move(shortest)};
}

/// Rejects a vertex that is so far from all its neighbours, compared with their own edges and with the
/// median, that a coordinate must be wrong.
void refuseOutlier(const TriangleMesh& mesh, const EdgeLengths& lengths, const std::string& name) {
  const double least = tolerance::outlierEdges * lengths.median;
  std::vector<double> around(mesh.vertices.size(), 0.0);  // largest `shortest` among the neighbours
  for (const Triangle& t : mesh.triangles)
    for (const int a : t)
      for (const int b : t)
        if (a != b && lengths.shortest[a] > least) around[a] = std::max(around[a], lengths.shortest[b]);
  for (std::size_t v = 0; v < around.size(); ++v)
    if (lengths.shortest[v] > std::max(least, tolerance::outlierEdges * around[v]))
      throw MeshError(name + ": the vertex at " + toText(mesh.vertices[v]) + " is " +
                      toText(lengths.shortest[v], 3) +
                      " away from all its neighbours, while the median edge length is " +
                      toText(lengths.median, 3) + "; a coordinate may be corrupt");
}

/// Orients triangles consistently. `component` receives the connected component of each triangle. Returns the
/// number of triangles flipped; empty if the surface is one-sided.
std::optional<std::size_t> orient(TriangleMesh& mesh, const std::vector<TriangleSide>& sides,
                                  std::vector<int>& component) {
  struct Neighbour {
    int triangle;
    bool agrees;
  };
  const std::size_t n = mesh.triangles.size();
  std::vector<Neighbour> neighbours(3 * n);
  std::vector<int> used(n, 0);
  for (std::size_t s = 0; s + 1 < sides.size(); s += 2) {
    const int a = sides[s].triangle, b = sides[s + 1].triangle;
    const bool agrees = sides[s].forwards != sides[s + 1].forwards;
    neighbours[3 * a + used[a]++] = {b, agrees};
    neighbours[3 * b + used[b]++] = {a, agrees};
  }
  component.assign(n, -1);
  std::vector<char> turned(n, 0);
  std::size_t turnedInAll = 0;
  int components = 0;
  for (std::size_t seed = 0; seed < n; ++seed) {
    if (component[seed] >= 0) continue;
    std::vector<int> reached{static_cast<int>(seed)};
    component[seed] = components;
    std::size_t turnedHere = 0;
    for (std::size_t k = 0; k < reached.size(); ++k)
      for (int e = 0; e < 3; ++e) {
        const Neighbour& next = neighbours[3 * reached[k] + e];
        const char shouldTurn = next.agrees ? turned[reached[k]] : !turned[reached[k]];
        if (component[next.triangle] < 0) {
          component[next.triangle] = components;
          turned[next.triangle] = shouldTurn;
          turnedHere += shouldTurn;
          reached.push_back(next.triangle);
        } else if (turned[next.triangle] != shouldTurn) {
          return std::nullopt;
        }
      }
    if (2 * turnedHere > reached.size()) {  // the first triangle was the wrong one
      for (const int t : reached) turned[t] = !turned[t];
      turnedHere = reached.size() - turnedHere;
    }
    turnedInAll += turnedHere;
    ++components;
  }
  for (std::size_t t = 0; t < n; ++t)
    if (turned[t]) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  return turnedInAll;
}

/// Whether every edge has as many triangles in one direction as in the other.
bool isBalanced(const std::vector<TriangleSide>& sides) {
  for (std::size_t from = 0, to = 0; from < sides.size(); from = to) {
    int balance = 0;
    for (to = from; to < sides.size() && sides[to].sameEdge(sides[from]); ++to)
      balance += sides[to].forwards ? 1 : -1;
    if (balance != 0) return false;
  }
  return true;
}

/// Moves parts that touch apart through the outside. @return the number of vertices in which they touched
std::size_t moveApart(TriangleMesh& mesh) {
  const bool inverted = signedVolume(mesh) < 0.0;
  if (inverted) flip(mesh);
  const std::size_t touching = moveTouchingPartsApart(mesh);
  if (inverted) flip(mesh);
  return touching;
}

/// Whether an odd number of the other components contain a vertex of `own`. Pre: components do not meet.
class Nesting {
 public:
  Nesting(const TriangleMesh& mesh, const std::vector<int>& component)
      : mesh_(mesh), component_(component), tree_(mesh), box_(boundingBox(mesh)) {
    box_.size().minCoeff(&axis_);  // along the shortest axis few triangles are met
  }

  bool isOdd(int own, const Vec3& at) const {
    Box ray{at, at};
    ray.hi[axis_] = box_.hi[axis_];
    bool odd = false;
    std::size_t near = 0;
    tree_.forEachNear(ray, [&](int t) {
      pollAt(near++);
      if (component_[t] != own && isAbove(t, at)) odd = !odd;
    });
    return odd;
  }

 private:
  /// Whether a triangle is met by the ray from `at` along the axis; of triangles with a common edge or vertex
  /// on the ray exactly one or, where the surface only touches it, none or two.
  bool isAbove(int t, const Vec3& at) const {
    const int u = (axis_ + 1) % 3, v = (axis_ + 2) % 3;
    bool seen = false;
    for (int k = 0; k < 3; ++k) {
      const Vec3 *a = &mesh_.corner(t, k), *b = &mesh_.corner(t, (k + 1) % 3);
      if (((*a)[v] <= at[v]) == ((*b)[v] <= at[v])) continue;
      if ((*a)[v] > (*b)[v]) std::swap(a, b);
      if (turn({(*a)[u], (*a)[v]}, {(*b)[u], (*b)[v]}, {at[u], at[v]}) > 0) seen = !seen;
    }
    if (!seen) return false;
    const Vec3 &a = mesh_.corner(t, 0), &b = mesh_.corner(t, 1), &c = mesh_.corner(t, 2);
    return sideOfPlane(a, b, c, at) * turnSeen(axis_, a, b, c) < 0;
  }

  const TriangleMesh& mesh_;
  const std::vector<int>& component_;
  TriangleTree tree_;
  Box box_;
  int axis_ = 0;
};

/// Flips whole components so that the outermost ones face outwards, those inside them inwards, and so on.
/// Returns the number of components flipped. Pre: components do not meet.
std::size_t orientComponents(TriangleMesh& mesh, const std::vector<int>& component, const std::string& name) {
  struct Part {
    int first = -1;  ///< its first triangle
    double sixVolumes = 0.0;
    Box box;
    bool wrong = false;
  };
  std::vector<Part> parts(1 + *std::max_element(component.begin(), component.end()));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Part& part = parts[component[t]];
    if (part.first < 0) part.first = static_cast<int>(t);
    const Vec3& at = mesh.corner(part.first, 0);
    const Vec3 &a = mesh.corner(t, 0), &b = mesh.corner(t, 1), &c = mesh.corner(t, 2);
    part.sixVolumes += (a - at).dot((b - at).cross(c - at));
    for (const int v : mesh.triangles[t]) part.box.add(mesh.vertices[v]);
  }
  std::optional<Nesting> nesting;
  if (parts.size() > 1) nesting.emplace(mesh, component);
  std::size_t turned = 0;
  for (std::size_t c = 0; c < parts.size(); ++c) {
    Part& part = parts[c];
    const Vec3& at = mesh.corner(part.first, 0);
    const double size = part.box.size().norm();
    if (std::abs(part.sixVolumes) < 6.0 * tolerance::zeroVolumeFraction * size * size * size)
      throw MeshError(name + ": the surface at " + toText(at) + " encloses no volume (" +
                      toText(part.sixVolumes / 6.0, 3) + " µm³)");
    const bool inverted = nesting && nesting->isOdd(static_cast<int>(c), at);
    part.wrong = (part.sixVolumes > 0.0) == inverted;
    turned += part.wrong;
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (parts[component[t]].wrong) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  return turned;
}

void checkInput(const TriangleMesh& mesh, const std::string& name) {
  if (mesh.triangles.empty()) throw MeshError(name + ": the mesh has no triangles");
  for (const Triangle& t : mesh.triangles)
    for (const int v : t) {
      if (v < 0 || v >= static_cast<int>(mesh.vertices.size()))
        throw MeshError(name + ": a triangle refers to vertex " + std::to_string(v) + " of " +
                        std::to_string(mesh.vertices.size()));
      if (const std::string fault = coordinateFault(mesh.vertices[v]); !fault.empty())
        throw MeshError(name + ": vertex " + std::to_string(v) + fault);
    }
}

/// Rejects a surface without triangles, or all of whose vertices are in a plane: a cap alone, or what lost a
/// coordinate.
void refuseFlat(const TriangleMesh& mesh, const std::string& name) {
  if (mesh.triangles.empty()) throw MeshError(name + ": all triangles of the mesh are collapsed");
  const double size = boundingBox(mesh).size().norm();
  Vec3 normal = Vec3::Zero();
  double largest = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 area = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
    if (area.norm() > largest) {
      largest = area.norm();
      normal = area.normalized();
    }
  }
  const Vec3& origin = mesh.corner(0, 0);
  if (std::all_of(mesh.vertices.begin(), mesh.vertices.end(), [&](const Vec3& v) {
        return std::abs(normal.dot(v - origin)) <= tolerance::flatSurfaceFraction * size;
      }))
    throw MeshError(name + ": the surface is flat, so that it encloses no volume");
}

std::string edgeText(const TriangleMesh& mesh, const TriangleSide& side) {
  return "from " + toText(mesh.vertices[side.lo]) + " to " + toText(mesh.vertices[side.hi]);
}

/// @return why the openings are not closed; empty: they are
std::string closeOpenings(TriangleMesh& mesh, const std::vector<TriangleSide>& sides, double flatness,
                          std::vector<CappedOpening>& capped) {
  const std::string fault = capFlatOpenings(mesh, sides, flatness, capped);
  if (fault.empty()) return {};
  return "; only flat openings can be capped, and " + fault +
         ". Cut the end off by a plane, or close it in a mesh editor";
}

/// @param notCapped why openings were not capped
void refuseFaults(const TriangleMesh& mesh, const EdgeFaults& faults, const std::string& notCapped,
                  const std::string& name) {
  if (faults.open > 0)
    throw MeshError(name + ": the surface is not closed: it has " +
                    counted(faults.open, "open edge", "open edges") + ", the first " +
                    edgeText(mesh, faults.firstOpen) + notCapped);
  if (faults.crowded > 0)
    throw MeshError(name + ": the surface is not manifold: more than two triangles meet at " +
                    counted(faults.crowded, "edge", "edges") + ", the first " +
                    edgeText(mesh, faults.firstCrowded) + "; separate the parts in a mesh editor");
}

/// Removes flat triangles with rounded corners if they cross their neighbours. @return their number
/// @param crossing if not null, where the surface intersects itself otherwise
/// @throws MeshError if it is null and the surface does, or if there is a triangle without area
std::size_t removeSlivers(TriangleMesh& mesh, const std::string& name, std::string* crossing) {
  const std::optional<TrianglePair> pair = findSelfIntersection(mesh);
  if (!pair) return 0;
  TriangleMesh mended = mesh;
  const std::size_t slivers = removeFlatTriangles(mended, tolerance::sliverFlatness);
  if (slivers > 0 && !findSelfIntersection(mended)) {
    mesh = std::move(mended);
    return slivers;
  }
  const auto middle = [&](int t) {
    return Vec3((mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3.0);
  };
  if (pair->first == pair->second)
    throw MeshError(name + ": the triangle at " + toText(middle(pair->first)) + " has no area");
  const std::string where = "the surface intersects itself: the triangles at " + toText(middle(pair->first)) +
                            " and " + toText(middle(pair->second)) + " intersect";
  if (!crossing)
    throw MeshError(name + ": " + where + "; join the parts (Boolean union) or remesh them in a mesh editor");
  *crossing = where;
  return 0;
}

}  // namespace

std::vector<std::string> repairClosed(TriangleMesh& mesh, const std::string& name,
                                      std::vector<CappedOpening>* capped, double flatness,
                                      std::string* crossing) {
  checkInput(mesh, name);
  poll();
  std::vector<std::string> repairs;
  const auto note = [&](std::size_t n, const std::string& verb, const std::string& one,
                        const std::string& many) {
    if (n > 0) repairs.push_back(name + ": " + verb + " " + counted(n, one, many));
  };

  note(mergeEqualVertices(mesh), "merged", "duplicate vertex", "duplicate vertices");
  note(removeCollapsed(mesh), "removed", "collapsed triangle", "collapsed triangles");
  refuseFlat(mesh, name);
  note(removeCoincident(mesh), "removed", "triangle that coincided with another",
       "triangles that coincided with others");
  note(removeUnusedVertices(mesh), "removed", "unused vertex", "unused vertices");

  const EdgeLengths lengths = edgeLengthsOf(mesh);
  refuseOutlier(mesh, lengths, name);
  Edges edges(mesh);
  if (edges.faults.open > 0 && edges.faults.crowded == 0) {
    if (const std::size_t joined = closeCracks(mesh, edges.faults, lengths.median, capped)) {
      note(joined, "closed cracks by merging", "vertex that differed by rounding",
           "vertices that differed by rounding");
      edges = Edges(mesh);
    }
  }
  std::string notCapped;
  if (capped && edges.faults.open > 0 && edges.faults.crowded == 0) {
    notCapped = closeOpenings(mesh, edges.sides, flatness, *capped);
    edges = Edges(mesh);
  }
  std::size_t touching = 0;
  if (edges.areCrowded()) {
    if (const std::size_t joined = mergeNear(mesh, lengths.median)) {
      note(joined, "merged", "vertex very near another", "vertices very near others");
      edges = Edges(mesh);
    }
  }
  if (edges.areCrowded() && isBalanced(edges.sides)) {
    touching = moveApart(mesh);
    edges = Edges(mesh);
  }
  refuseFaults(mesh, edges.faults, notCapped, name);
  if (mesh.triangles.empty()) throw MeshError(name + ": all triangles cancel each other");

  std::vector<int> component;
  const std::optional<std::size_t> turned = orient(mesh, edges.sides, component);
  if (!turned) throw MeshError(name + ": the surface is one-sided (like a Klein bottle) and has no interior");
  note(*turned, "flipped", "triangle oriented against its neighbours",
       "triangles oriented against their neighbours");
  touching += moveApart(mesh);
  note(touching, "moved parts of the surface apart that touched in", "vertex", "vertices");
  note(removeFlatTriangles(mesh), "repaired", "triangle without area", "triangles without area");
  note(removeSlivers(mesh, name, crossing), "repaired", "sliver", "slivers");
  note(orientComponents(mesh, component, name), "flipped", "surface that was inside out",
       "surfaces that were inside out");
  return repairs;
}

}  // namespace packmesh
