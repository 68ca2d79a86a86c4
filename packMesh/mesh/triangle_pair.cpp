// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/triangle_pair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "packMesh/mesh/predicates.h"

namespace packmesh {

namespace {

/// Drops one coordinate: exact, and one-to-one on every plane not parallel to that axis.
Vec2 project(const Vec3& p, int axis) {
  return {p[(axis + 1) % 3], p[(axis + 2) % 3]};
}

template <class Vector>
bool boxesMeet(const Vector& p, const Vector& q, const Vector& r, const Vector& s) {
  return (p.cwiseMin(q).array() <= r.cwiseMax(s).array()).all() &&
         (r.cwiseMin(s).array() <= p.cwiseMax(q).array()).all();
}

/// The four turns that determine the relative position of two segments in the plane.
struct SegmentTurns {
  int pqr, pqs, rsp, rsq;

  SegmentTurns(const Vec2& p, const Vec2& q, const Vec2& r, const Vec2& s)
      : pqr(turn(p, q, r)), pqs(turn(p, q, s)), rsp(turn(r, s, p)), rsq(turn(r, s, q)) {}
  bool collinear() const { return pqr == 0 && pqs == 0 && rsp == 0 && rsq == 0; }
  /// Pre: not collinear. Each segment has points on both sides of, or on, the line through the other.
  bool meet() const { return pqr * pqs <= 0 && rsp * rsq <= 0; }
};

bool segmentsMeet(const Vec2& p, const Vec2& q, const Vec2& r, const Vec2& s) {
  const SegmentTurns turns(p, q, r, s);
  return turns.collinear() ? boxesMeet(p, q, r, s) : turns.meet();
}

bool segmentsMeet(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
  if (sideOfPlane(p, q, r, s) != 0) return false;
  // Coplanar. A projection in which three of the points are not collinear is one-to-one on their plane.
  for (int axis = 0; axis < 3; ++axis) {
    const SegmentTurns turns(project(p, axis), project(q, axis), project(r, axis), project(s, axis));
    if (!turns.collinear()) return turns.meet();
  }
  return boxesMeet(p, q, r, s);  // all on one line
}

/// Pre: abc not collinear, given counter-clockwise or clockwise as `orientation` says.
bool triangleContains(const Vec2& a, const Vec2& b, const Vec2& c, int orientation, const Vec2& p) {
  return turn(a, b, p) * orientation >= 0 && turn(b, c, p) * orientation >= 0 &&
         turn(c, a, p) * orientation >= 0;
}

/// Pre: a, b, c, p, q coplanar, or a, b, c collinear.
bool flatSegmentMeetsTriangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  for (int axis = 0; axis < 3; ++axis) {
    const Vec2 a2 = project(a, axis), b2 = project(b, axis), c2 = project(c, axis);
    const int orientation = turn(a2, b2, c2);
    if (orientation == 0) continue;
    const Vec2 p2 = project(p, axis), q2 = project(q, axis);
    return triangleContains(a2, b2, c2, orientation, p2) || segmentsMeet(p2, q2, a2, b2) ||
           segmentsMeet(p2, q2, b2, c2) || segmentsMeet(p2, q2, c2, a2);
  }
  // A degenerate triangle is the union of its edges.
  return segmentsMeet(p, q, a, b) || segmentsMeet(p, q, b, c) || segmentsMeet(p, q, c, a);
}

/// Signs of the volumes spanned by pq and the edges of abc: they are equal where the line pq passes through
/// abc.
struct LineSigns {
  int ab, bc, ca;

  LineSigns(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c)
      : ab(sideOfPlane(p, q, a, b)), bc(sideOfPlane(p, q, b, c)), ca(sideOfPlane(p, q, c, a)) {}
  bool throughClosed() const { return (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0); }
  bool throughInterior() const { return ab != 0 && ab == bc && bc == ca; }
};

/// @param sideP, sideQ sides of the plane abc on which p and q lie
bool segmentMeetsTriangle(const Vec3& p, const Vec3& q, int sideP, int sideQ, const Vec3& a, const Vec3& b,
                          const Vec3& c) {
  if (sideP * sideQ > 0) return false;
  if (sideP == 0 && sideQ == 0) return flatSegmentMeetsTriangle(p, q, a, b, c);
  // The segment meets the plane in one point; it lies in the triangle if the line passes through the
  // triangle.
  return LineSigns(p, q, a, b, c).throughClosed();
}

bool anyEdgeMeetsTriangle(const std::array<const Vec3*, 3>& edges, const std::array<int, 3>& side,
                          const Vec3& a, const Vec3& b, const Vec3& c) {
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    if (segmentMeetsTriangle(*edges[k], *edges[l], side[k], side[l], a, b, c)) return true;
  }
  return false;
}

bool allOnOneSide(const std::array<int, 3>& side) {
  return side[0] != 0 && side[0] == side[1] && side[1] == side[2];
}

}  // namespace

bool segmentMeetsTriangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  return segmentMeetsTriangle(p, q, sideOfPlane(a, b, c, p), sideOfPlane(a, b, c, q), a, b, c);
}

bool segmentCrossesTriangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  return sideOfPlane(a, b, c, p) * sideOfPlane(a, b, c, q) < 0 && LineSigns(p, q, a, b, c).throughInterior();
}

// An extreme point of the intersection of two triangles cannot be interior to both (two planes share at least
// a line), so triangles meet exactly when an edge of one meets the other.
bool trianglesMeet(const Vec3& a0, const Vec3& a1, const Vec3& a2, const Vec3& b0, const Vec3& b1,
                   const Vec3& b2) {
  const std::array<int, 3> sideB = {sideOfPlane(a0, a1, a2, b0), sideOfPlane(a0, a1, a2, b1),
                                    sideOfPlane(a0, a1, a2, b2)};
  if (allOnOneSide(sideB)) return false;
  const std::array<int, 3> sideA = {sideOfPlane(b0, b1, b2, a0), sideOfPlane(b0, b1, b2, a1),
                                    sideOfPlane(b0, b1, b2, a2)};
  if (allOnOneSide(sideA)) return false;
  return anyEdgeMeetsTriangle({&b0, &b1, &b2}, sideB, a0, a1, a2) ||
         anyEdgeMeetsTriangle({&a0, &a1, &a2}, sideA, b0, b1, b2);
}

namespace {

double clampToUnit(double x) {
  return x > 0.0 ? (x < 1.0 ? x : 1.0) : 0.0;
}

/// Corner, the three edges and the normal of a triangle.
struct Parts {
  Vec3 corner[3], edge[3], normal;
  double edgeSquared[3], normalSquared;

  Parts(const Vec3& a, const Vec3& b, const Vec3& c) : corner{a, b, c}, edge{b - a, c - b, a - c} {
    normal = edge[0].cross(edge[1]);
    normalSquared = normal.squaredNorm();
    for (int k = 0; k < 3; ++k) edgeSquared[k] = edge[k].squaredNorm();
  }
};

/// Squared distance of the corners of `p` to the interior of `t`, if their projections lie inside it.
double cornersToFace(const Parts& p, const Parts& t) {
  double least = std::numeric_limits<double>::infinity();
  if (!(t.normalSquared > 0.0)) return least;
  const Vec3 inward[3] = {t.normal.cross(t.edge[0]), t.normal.cross(t.edge[1]), t.normal.cross(t.edge[2])};
  for (const Vec3& corner : p.corner) {
    if (inward[0].dot(corner - t.corner[0]) < 0.0 || inward[1].dot(corner - t.corner[1]) < 0.0 ||
        inward[2].dot(corner - t.corner[2]) < 0.0)
      continue;
    const double height = t.normal.dot(corner - t.corner[0]);
    least = std::min(least, height * height / t.normalSquared);
  }
  return least;
}

/// Squared distance of the corners of `p` to the edges of `t`.
double cornersToEdges(const Parts& p, const Parts& t) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vec3& corner : p.corner)
    for (int k = 0; k < 3; ++k) {
      const Vec3 offset = corner - t.corner[k];
      const double s = t.edgeSquared[k] > 0.0 ? clampToUnit(offset.dot(t.edge[k]) / t.edgeSquared[k]) : 0.0;
      least = std::min(least, (offset - s * t.edge[k]).squaredNorm());
    }
  return least;
}

/// Squared distance between edges whose nearest points are both interior. It is computed between two points
/// on the edges, so that an ill-conditioned (nearly parallel) pair cannot give too small a value; the end
/// points of such edges are as near and are covered by cornersToEdges.
double edgesToEdges(const Parts& p, const Parts& t) {
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k)
    for (int l = 0; l < 3; ++l) {
      const Vec3 offset = t.corner[l] - p.corner[k];
      const double cosine = p.edge[k].dot(t.edge[l]);
      const double determinant = p.edgeSquared[k] * t.edgeSquared[l] - cosine * cosine;
      if (!(determinant > 0.0)) continue;
      const double alongP = offset.dot(p.edge[k]), alongT = offset.dot(t.edge[l]);
      const double s = (alongP * t.edgeSquared[l] - alongT * cosine) / determinant;
      const double u = (alongP * cosine - alongT * p.edgeSquared[k]) / determinant;
      if (s > 0.0 && s < 1.0 && u > 0.0 && u < 1.0)
        least = std::min(least, (offset + u * t.edge[l] - s * p.edge[k]).squaredNorm());
    }
  return least;
}

}  // namespace

double triangleDistance(const Vec3& a0, const Vec3& a1, const Vec3& a2, const Vec3& b0, const Vec3& b1,
                        const Vec3& b2) {
  // Relative to a corner, so that the position of distant triangles causes no further loss of digits.
  const Parts a(Vec3::Zero(), a1 - a0, a2 - a0), b(b0 - a0, b1 - a0, b2 - a0);
  return std::sqrt(std::min({cornersToFace(a, b), cornersToFace(b, a), cornersToEdges(a, b),
                             cornersToEdges(b, a), edgesToEdges(a, b)}));
}

}  // namespace packmesh
