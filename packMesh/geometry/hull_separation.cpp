// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/geometry/hull_separation.h"

#include <cmath>

namespace packmesh {

namespace {

/// Pairs that nest take a few rounds until the origin is enclosed; more rounds than this are not worth it.
constexpr int maxRounds = 20;

/// A simplex of the Minkowski difference; the newest point is the last.
struct Simplex {
  Vec3 point[4];
  int size = 0;

  /// Adds a point that lies nearer to the origin's side than all others, keeps only the face nearest to the
  /// origin and returns its nearest point. That face has the new point in it.
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

  /// Whether the origin is on the inner side of the three faces at p.
  static bool encloses(const Vec3& p, const Vec3 (&old)[3]) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 normal = (old[k] - p).cross(old[(k + 1) % 3] - p);
      if (normal.dot(p) * normal.dot(old[(k + 2) % 3] - p) > 0.0) return false;
    }
    return true;
  }
};

}  // namespace

Support furthest(const MeshTree& tree, const Vec3& direction) {
  const Float4 x = splat(static_cast<float>(direction[0])), y = splat(static_cast<float>(direction[1])),
               z = splat(static_cast<float>(direction[2])),
               length = splat(static_cast<float>(direction.norm()));
  // Upper bounds of all clusters; the most promising one is looked into first, to rule out most others.
  const int quads = static_cast<int>(tree.clusterX.size());
  constexpr int buffered = 64;  // meshes of more than 4096 vertices compute the bounds twice
  Float4 bounds[buffered];
  Float4 highest = splat(-1e30f);
  Int4 where = {0, 0, 0, 0};
  const auto bound = [&](int q) {
    return x * tree.clusterX[q] + y * tree.clusterY[q] + z * tree.clusterZ[q] +
           length * tree.clusterRadius[q];
  };
  for (int q = 0; q < quads; ++q) {
    const Float4 value = bound(q);
    if (q < buffered) bounds[q] = value;
    const Int4 here = Int4{4 * q, 4 * q + 1, 4 * q + 2, 4 * q + 3};
    where = value > highest ? here : where;
    highest = max(highest, value);
  }
  int best = 0;
  for (int lane = 1; lane < 4; ++lane)
    if (highest[lane] > highest[best]) best = lane;

  Support out{-1, -1e30f};
  const auto look = [&](int c) {
    const PointCluster& cluster = tree.clusters[c];
    Float4 value = x * cluster.x[0] + y * cluster.y[0] + z * cluster.z[0];
    Int4 part = {0, 1, 2, 3};
    for (int k = 1; k < 4; ++k) {
      const Float4 other = x * cluster.x[k] + y * cluster.y[k] + z * cluster.z[k];
      part = other > value ? Int4{4 * k, 4 * k + 1, 4 * k + 2, 4 * k + 3} : part;
      value = max(value, other);
    }
    for (int lane = 0; lane < 4; ++lane)
      if (value[lane] > out.value) out = {cluster.vertex[part[lane]], value[lane]};
  };
  const int first = where[best];
  look(first);
  for (int q = 0; q < quads; ++q) {
    const Int4 promising = (q < buffered ? bounds[q] : bound(q)) > splat(out.value);
    if (!(promising[0] | promising[1] | promising[2] | promising[3])) continue;
    for (int lane = 0; lane < 4; ++lane)
      if (promising[lane] && 4 * q + lane != first) look(4 * q + lane);
  }
  return out;
}

bool hullsApart(const MeshTree& first, const MeshTree& second, const Mat3& linear, const Vec3& translation,
                double distance, double rounding) {
  Vec3 toOrigin = first.center - (linear * second.center + translation);
  if (toOrigin.squaredNorm() == 0.0) return false;
  Simplex simplex;
  for (int round = 0; round < maxRounds; ++round) {
    const Vec3 direction = toOrigin.normalized();
    const Vec3 fromSecond = linear.transpose() * direction;
    const Support a = furthest(first, -direction), b = furthest(second, fromSecond);
    const double gap = -double(a.value) - (double(b.value) + direction.dot(translation));
    if (gap - rounding > distance) return true;
    const Vec3 point =
        first.mesh.vertices[a.vertex] - (linear * second.mesh.vertices[b.vertex] + translation);
    // No nearer than the simplex already is: its distance is that of the hulls, and too small.
    if (round > 0 && direction.dot(point) > toOrigin.norm() - rounding) return false;
    toOrigin = simplex.add(point);
    if (toOrigin.norm() <= distance + rounding) return false;
  }
  return false;
}

}  // namespace packmesh
