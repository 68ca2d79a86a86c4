// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/self_intersection.h"

#include <algorithm>

#include "packMesh/core/poll.h"
#include "packMesh/mesh/predicates.h"
#include "packMesh/mesh/triangle_intersection.h"
#include "packMesh/mesh/triangle_tree.h"

namespace packmesh {

bool meetBeyondShared(const std::vector<Vec3>& v, Triangle a, Triangle b) {
  // Move the shared vertices to the front of both.
  int shared = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = shared; j < 3; ++j)
      if (a[i] == b[j]) {
        std::swap(a[i], a[shared]);
        std::swap(b[j], b[shared]);
        ++shared;
        break;
      }
  const Vec3 &a0 = v[a[0]], &a1 = v[a[1]], &a2 = v[a[2]], &b0 = v[b[0]], &b1 = v[b[1]], &b2 = v[b[2]];
  switch (shared) {
    case 0:
      return trianglesMeet(a0, a1, a2, b0, b1, b2);
    case 1:
      // The intersection is convex and contains the vertex; if it contains more, it leaves one triangle
      // through the opposite edge while still inside the other triangle.
      return segmentMeetsTriangle(a1, a2, b0, b1, b2) || segmentMeetsTriangle(b1, b2, a0, a1, a2);
    case 2: {
      if (sideOfPlane(a0, a1, a2, b2) != 0) return false;
      const int drop = axisShowing(a0, a1, a2);
      return turnSeen(drop, a0, a1, a2) == turnSeen(drop, a0, a1, b2);  // folded onto each other
    }
    default:
      return true;
  }
}

std::optional<TrianglePair> findSelfIntersection(const TriangleMesh& mesh) {
  std::optional<TrianglePair> found;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const int n = static_cast<int>(t);
    pollAt(t);
    if (axisShowing(mesh.corner(n, 0), mesh.corner(n, 1), mesh.corner(n, 2)) < 0) return TrianglePair(n, n);
  }
  std::size_t pairs = 0;
  TriangleTree(mesh).forEachPair(mesh, [&](int s, int t) {
    pollAt(pairs++);
    if (meetBeyondShared(mesh.vertices, mesh.triangles[s], mesh.triangles[t])) found = std::minmax(s, t);
    return !found;
  });
  return found;
}

}  // namespace packmesh
