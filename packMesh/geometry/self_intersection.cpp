// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/geometry/self_intersection.h"

#include <algorithm>

#include "packMesh/geometry/triangle_tree.h"

namespace packmesh {
namespace {

int sign(double x) {
  return (x > 0.0) - (x < 0.0);
}

/// Side of d with respect to the plane through a, b, c.
int side(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return sign((a - d).dot((b - d).cross(c - d)));
}

/// Turn of a, b, c seen along axis `drop`.
int turn(const Vec3& a, const Vec3& b, const Vec3& c, int drop) {
  const int i = (drop + 1) % 3, j = (drop + 2) % 3;
  return sign((a[i] - c[i]) * (b[j] - c[j]) - (a[j] - c[j]) * (b[i] - c[i]));
}

/// An axis along which triangle a, b, c is seen as a triangle; -1 when it has no area.
int axisShowing(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a).cwiseAbs();
  int best = 0;
  normal.maxCoeff(&best);
  for (int k = 0; k < 3; ++k)
    if (turn(a, b, c, (best + k) % 3) != 0) return (best + k) % 3;
  return -1;
}

/// Whether closed segment p q meets closed triangle a, b, c. Pre: the triangle has area.
bool segmentMeets(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const int sp = side(a, b, c, p), sq = side(a, b, c, q);
  if (sp * sq > 0) return false;
  if (sp != 0 || sq != 0) {
    // The line through p and q pierces the plane between them: it hits the triangle when it passes all edges
    // on one side.
    const int e0 = side(p, q, a, b), e1 = side(p, q, b, c), e2 = side(p, q, c, a);
    return (e0 >= 0 && e1 >= 0 && e2 >= 0) || (e0 <= 0 && e1 <= 0 && e2 <= 0);
  }
  const int drop = axisShowing(a, b, c);
  const int facing = turn(a, b, c, drop);
  const Vec3* corner[3] = {&a, &b, &c};
  bool pInside = true, qInside = true;
  for (int k = 0; k < 3; ++k) {
    const Vec3 &u = *corner[k], &v = *corner[(k + 1) % 3];
    const int up = turn(u, v, p, drop) * facing, uq = turn(u, v, q, drop) * facing;
    pInside &= up >= 0;
    qInside &= uq >= 0;
    if (up < 0 && uq < 0) return false;  // the whole segment is beyond this edge
  }
  if (pInside || qInside) return true;
  // No edge of the triangle separates; only the line of the segment still can.
  const int ta = turn(p, q, a, drop), tb = turn(p, q, b, drop), tc = turn(p, q, c, drop);
  return !((ta > 0 && tb > 0 && tc > 0) || (ta < 0 && tb < 0 && tc < 0));
}

/// Whether two triangles without common vertices meet.
bool disjointTrianglesMeet(const Vec3& a0, const Vec3& a1, const Vec3& a2, const Vec3& b0, const Vec3& b1,
                           const Vec3& b2) {
  const Vec3 *a[3] = {&a0, &a1, &a2}, *b[3] = {&b0, &b1, &b2};
  for (int k = 0; k < 3; ++k)
    if (segmentMeets(*a[k], *a[(k + 1) % 3], b0, b1, b2) || segmentMeets(*b[k], *b[(k + 1) % 3], a0, a1, a2))
      return true;
  return false;
}

/// Whether two triangles meet elsewhere than in what they share.
bool meetBeyondShared(const TriangleMesh& mesh, int s, int t) {
  Triangle a = mesh.triangles[s], b = mesh.triangles[t];
  // Bring the shared vertices to the front of both.
  int shared = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = shared; j < 3; ++j)
      if (a[i] == b[j]) {
        std::swap(a[i], a[shared]);
        std::swap(b[j], b[shared]);
        ++shared;
        break;
      }
  const std::vector<Vec3>& v = mesh.vertices;
  const Vec3 &a0 = v[a[0]], &a1 = v[a[1]], &a2 = v[a[2]], &b0 = v[b[0]], &b1 = v[b[1]], &b2 = v[b[2]];
  switch (shared) {
    case 0:
      return disjointTrianglesMeet(a0, a1, a2, b0, b1, b2);
    case 1:
      // The common part is convex and holds the vertex; where more of it leaves one triangle, it does so
      // through the edge opposite, still inside the other triangle.
      return segmentMeets(a1, a2, b0, b1, b2) || segmentMeets(b1, b2, a0, a1, a2);
    case 2: {
      if (side(a0, a1, a2, b2) != 0) return false;
      const int drop = axisShowing(a0, a1, a2);
      return turn(a0, a1, a2, drop) == turn(a0, a1, b2, drop);  // folded onto each other
    }
    default:
      return true;
  }
}

}  // namespace

std::optional<TrianglePair> findSelfIntersection(const TriangleMesh& mesh) {
  std::optional<TrianglePair> found;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const int n = static_cast<int>(t);
    if (axisShowing(mesh.corner(n, 0), mesh.corner(n, 1), mesh.corner(n, 2)) < 0) return TrianglePair(n, n);
  }
  TriangleTree(mesh).forEachPair([&](int s, int t) {
    if (!found && meetBeyondShared(mesh, s, t)) found = std::minmax(s, t);
  });
  return found;
}

}  // namespace packmesh
