// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/touching_parts.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/joined_sets.h"
#include "packMesh/mesh/merge_vertices.h"

namespace packmesh {
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
  JoinedSets sets(corners);
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
