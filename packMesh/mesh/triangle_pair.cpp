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

using Pair = double __attribute__((vector_size(16)));

// Distances are computed for three corners or edges at once, in pairs of doubles, which all processors have:
// the kernels' lanes are floats. There are no branches; mispredicted ones took half of the time.

/// Where a comparison of three numbers holds.
struct Choice {
  decltype(Pair{} < Pair{}) a, b;
  friend Choice operator&(const Choice& l, const Choice& r) { return {l.a & r.a, l.b & r.b}; }
};

/// Three numbers, of corners or edges; the last one twice.
struct Triple {
  Pair a, b;

  Triple(const Pair& firstTwo, const Pair& last) : a(firstTwo), b(last) {}
  Triple(double all) : Triple(all, all, all) {}
  Triple(double first, double second, double third) : a{first, second}, b{third, third} {}

  friend Triple operator+(const Triple& l, const Triple& r) { return {l.a + r.a, l.b + r.b}; }
  friend Triple operator-(const Triple& l, const Triple& r) { return {l.a - r.a, l.b - r.b}; }
  friend Triple operator*(const Triple& l, const Triple& r) { return {l.a * r.a, l.b * r.b}; }
  friend Triple operator/(const Triple& l, const Triple& r) { return {l.a / r.a, l.b / r.b}; }
  friend Choice operator<(const Triple& l, const Triple& r) { return {l.a < r.a, l.b < r.b}; }
  friend Triple select(const Choice& where, const Triple& l, const Triple& r) {
    return {where.a ? l.a : r.a, where.b ? l.b : r.b};
  }
};

/// The lesser of each two; `l` where `r` is NaN.
Triple least(const Triple& l, const Triple& r) {
  return select(r < l, r, l);
}
double leastOf(const Triple& all) {
  return std::min({all.a[0], all.a[1], all.b[0]});
}

/// Squared distances of what is not near.
const Triple farAway = std::numeric_limits<double>::infinity();

/// Three points or vectors.
struct Points {
  Triple x, y, z;

  Points(const Triple& xs, const Triple& ys, const Triple& zs) : x(xs), y(ys), z(zs) {}
  Points(const Vec3& a, const Vec3& b, const Vec3& c)
      : x(a.x(), b.x(), c.x()), y(a.y(), b.y(), c.y()), z(a.z(), b.z(), c.z()) {}
  explicit Points(const Vec3& all) : x(all.x()), y(all.y()), z(all.z()) {}

  Triple dot(const Points& r) const { return x * r.x + y * r.y + z * r.z; }
  Triple squaredNorm() const { return dot(*this); }
  friend Points operator+(const Points& l, const Points& r) { return {l.x + r.x, l.y + r.y, l.z + r.z}; }
  friend Points operator-(const Points& l, const Points& r) { return {l.x - r.x, l.y - r.y, l.z - r.z}; }
  friend Points operator*(const Triple& s, const Points& r) { return {s * r.x, s * r.y, s * r.z}; }
};

/// Corners, edges and normal of a triangle.
struct Parts {
  Vec3 corner[3], edge[3], normal;
  double edgeSquared[3], normalSquared;
  // All at once:
  Points corners, edges;
  Triple edgesSquared;

  Parts(const Vec3& a, const Vec3& b, const Vec3& c)
      : corner{a, b, c},
        edge{b - a, c - b, a - c},
        normal(edge[0].cross(edge[1])),
        edgeSquared{edge[0].squaredNorm(), edge[1].squaredNorm(), edge[2].squaredNorm()},
        normalSquared(normal.squaredNorm()),
        corners(a, b, c),
        edges(edge[0], edge[1], edge[2]),
        edgesSquared(edgeSquared[0], edgeSquared[1], edgeSquared[2]) {}
};

/// Squared distances of the corners of `p` to the interior of `t`, if their projections lie inside it.
Triple cornersToFace(const Parts& p, const Parts& t) {
  if (!(t.normalSquared > 0.0)) return farAway;
  const Points normal(t.normal);
  const Triple height = normal.dot(p.corners - Points(t.corner[0]));
  Triple distance = height * height / t.normalSquared;
  for (int k = 0; k < 3; ++k) {
    const Triple inward = Points(t.normal.cross(t.edge[k])).dot(p.corners - Points(t.corner[k]));
    distance = select(inward < 0.0, farAway, distance);
  }
  return least(farAway, distance);
}

/// Squared distances of the corners of `p` to the edges of `t`, the least to each.
Triple cornersToEdges(const Parts& p, const Parts& t) {
  Triple nearest = farAway;
  for (const Vec3& corner : p.corner) {
    const Points offset = Points(corner) - t.corners;
    const Triple along = offset.dot(t.edges) / t.edgesSquared, within = select(along < 1.0, along, 1.0);
    const Triple s = select((0.0 < along) & (0.0 < t.edgesSquared), within, 0.0);
    nearest = least(nearest, (offset - s * t.edges).squaredNorm());
  }
  return nearest;
}

/// Squared distances between edges whose nearest points are both interior, the least to each of `t`. They are
/// computed between two points on the edges, so that an ill-conditioned (nearly parallel) pair cannot give
/// too small a value; the end points of such edges are as near and are covered by cornersToEdges.
Triple edgesToEdges(const Parts& p, const Parts& t) {
  Triple nearest = farAway;
  for (int k = 0; k < 3; ++k) {
    const Points edge(p.edge[k]), offset = t.corners - Points(p.corner[k]);
    const Triple cosine = edge.dot(t.edges), alongP = offset.dot(edge), alongT = offset.dot(t.edges);
    const Triple determinant = p.edgeSquared[k] * t.edgesSquared - cosine * cosine;
    const Triple s = (alongP * t.edgesSquared - alongT * cosine) / determinant;
    const Triple u = (alongP * cosine - alongT * p.edgeSquared[k]) / determinant;
    const Choice inside = (0.0 < determinant) & (0.0 < s) & (s < 1.0) & (0.0 < u) & (u < 1.0);
    const Triple squared = (offset + u * t.edges - s * edge).squaredNorm();
    nearest = least(nearest, select(inside, squared, farAway));
  }
  return nearest;
}

}  // namespace

double triangleDistance(const Vec3& a0, const Vec3& a1, const Vec3& a2, const Vec3& b0, const Vec3& b1,
                        const Vec3& b2) {
  // Relative to a corner, so that the position of distant triangles causes no further loss of digits.
  const Parts a(Vec3::Zero(), a1 - a0, a2 - a0), b(b0 - a0, b1 - a0, b2 - a0);
  const Triple corners = least(least(cornersToFace(a, b), cornersToFace(b, a)),
                               least(cornersToEdges(a, b), cornersToEdges(b, a)));
  return std::sqrt(leastOf(least(corners, edgesToEdges(a, b))));
}

}  // namespace packmesh
