// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/triangle_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace packmesh {

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
