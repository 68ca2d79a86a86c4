// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/coincident_triangles.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

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

}  // namespace packmesh
