// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/hull_separation.h"

#include <cmath>

namespace packmesh {

namespace {

/// Maximum number of rounds. Nested pairs need a few until the origin is enclosed; more are not worth their
/// time.
constexpr int maxRounds = 20;

/// A simplex of the Minkowski difference; the last point is the newest.
struct Simplex {
  Vec3 point[4];
  int size = 0;

  /// Adds a point that lies further on the origin's side than all others, keeps only the face nearest to the
  /// origin and returns its nearest point. That face contains the new point.
  Vec3 add(const Vec3& p) {
    const Vec3 old[3] = {point[0], point[1], point[2]};
    const int count = size;
    Vec3 nearest = p;
    double least = p.squaredNorm();
    point[0] = p, size = 1;
    for (int i = 0; i < count; ++i) {
      const Vec3 edge = old[i] - p;
      const double along = -p.dot(edge), squared = edge.squaredNorm();
      if (along <= 0.0 || along >= squared) continue;
      keep(p + along / squared * edge, p, {old[i], old[i]}, 2, nearest, least);
    }
    for (int i = 0; i < count; ++i)
      for (int j = i + 1; j < count; ++j) {
        const Vec3 e = old[i] - p, f = old[j] - p;
        const double ee = e.squaredNorm(), ef = e.dot(f), ff = f.squaredNorm(), pe = -p.dot(e),
                     pf = -p.dot(f);
        const double determinant = ee * ff - ef * ef;
        const double s = pe * ff - pf * ef, t = pf * ee - pe * ef;
        if (s <= 0.0 || t <= 0.0 || s + t >= determinant) continue;
        keep(p + (s * e + t * f) / determinant, p, {old[i], old[j]}, 3, nearest, least);
      }
    if (count == 3 && encloses(p, old)) return Vec3::Zero();
    return nearest;
  }

 private:
  struct Others {
    Vec3 a, b;
  };
  void keep(const Vec3& candidate, const Vec3& p, const Others& others, int count, Vec3& nearest,
            double& least) {
    const double squared = candidate.squaredNorm();
    if (squared >= least) return;
    least = squared;
    nearest = candidate;
    point[0] = others.a;
    if (count == 3) point[1] = others.b;
    point[count - 1] = p;
    size = count;
  }

  /// True if the origin is on the inner side of the three faces at p.
  static bool encloses(const Vec3& p, const Vec3 (&old)[3]) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 normal = (old[k] - p).cross(old[(k + 1) % 3] - p);
      if (normal.dot(p) * normal.dot(old[(k + 2) % 3] - p) > 0.0) return false;
    }
    return true;
  }
};

}  // namespace

bool hullsApart(const ConvexHull& first, const ConvexHull& second, const Mat3& linear,
                const Vec3& translation, const Vec3& direction, double distance, double rounding) {
  const Mat3 transposed = linear.transpose();
  Vec3 toOrigin = direction;
  Simplex simplex;
  for (int round = 0; round < maxRounds; ++round) {
    const int a = first.furthest(-toOrigin), b = second.furthest(transposed * toOrigin);
    const Vec3 point = first.points()[a] - (linear * second.points()[b] + translation);
    const double length = toOrigin.norm(), gap = toOrigin.dot(point) / length;
    if (gap > distance + rounding) return true;
    // No progress: the distance of the simplex is that of the hulls, and too small.
    if (round > 0 && gap > length - rounding) return false;
    toOrigin = simplex.add(point);
    if (toOrigin.norm() <= distance + rounding) return false;
  }
  return false;
}

}  // namespace packmesh
