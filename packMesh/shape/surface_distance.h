// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Distance of a point from a shape, the surface point nearest to it, and points that represent the
/// volume of a shape.
#pragma once

#include <vector>

#include "packMesh/parallel/threads.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// Distance of points from one shape, in its body frame, in double precision: from the closed form where
/// there is one, else from the grid. (Kernels have the same in lanes of floats: field_lanes.h.)
class SurfaceDistance {
 public:
  /// References `shape`, which must outlive this.
  explicit SurfaceDistance(const Shape& shape);

  /// Distance, positive outside, and a unit vector away from the surface.
  /// Of a closed form: within 0.0006 µm near a red cell, up to twice the distance far away; inside an
  /// ellipsoid at most the depth, and half of it at least. Of a grid: see DistanceGrid.
  DistanceSample sample(const Vec3& p) const { return profile_ ? closedForm(p) : interpolated(p); }

  /// Whether it is certain, at little cost, that sample() would say more than `limit` [µm].
  bool isBeyond(const Vec3& p, double limit) const {
    if (!profile_) return false;
    // Where F > 0, the distance is F over at most |grad F|.
    const Level l = level(p);
    return l.value > 0.0 && l.value * l.value > limit * limit * l.gradient.squaredNorm();
  }

  /// The distance is at least this [µm].
  double lowerBound(const Vec3& p) const;

  /// A point of the surface near `p`, the nearest one up to the error of sample().
  /// @param sample that of `p`
  Vec3 foot(const Vec3& p, const DistanceSample& sample) const;

 private:
  /// F = y² - P(s) and its gradient.
  struct Level {
    double value;
    Vec3 gradient;
  };
  Level level(const Vec3& p) const;
  DistanceSample closedForm(const Vec3& p) const;
  DistanceSample interpolated(const Vec3& p) const;

  const ProfileSurface* profile_;
  const DistanceGrid* grid_;
  double bend_ = 0.0;       ///< [µm²]
  double curvature_ = 1.0;  ///< ProfileSurface::curvatureInside()
  double ring_, thickness_;
  Vec3 extent_;  ///< of the mesh, to either side of the body's origin [µm]
};

inline SurfaceDistance::Level SurfaceDistance::level(const Vec3& q) const {
  const ProfileSurface& f = *profile_;
  const double s = f.a * q.x() * q.x() + f.c * q.z() * q.z();
  const double inner = std::min(s, 1.0), beyond = s - inner, bend = bend_ * beyond;
  double value = f.p[5], slope = 5.0 * f.p[5];
  for (int k = 4; k >= 0; --k) value = value * inner + f.p[k];
  for (int k = 4; k >= 1; --k) slope = slope * inner + k * f.p[k];
  value += (slope + bend) * beyond;
  slope += 2.0 * bend;
  return {q.y() * q.y() - value, {-2.0 * slope * f.a * q.x(), 2.0 * q.y(), -2.0 * slope * f.c * q.z()}};
}

/// Points inside shapes, in their body frames [µm]. Any thread may use it.
class InnerPoints {
 public:
  explicit InnerPoints(int count) : count_(count) {}

  /// `count` evenly spread points (Halton sequence); fewer, but at least one, if the shape fills less than a
  /// thousandth of its bounding box. The first n points are those of InnerPoints(n). A deformed cell has
  /// those of its template, each moved as the vertex that is nearest there.
  std::vector<Vec3> operator()(const Shape& shape) const;

 private:
  struct OfTemplate {
    std::vector<Vec3> points;
    std::vector<std::size_t> nearest;  ///< vertex of each
  };
  OfTemplate made(const Shape& shape) const;

  int count_;
  mutable MadeOnce<const Shape*, OfTemplate> templates_;
};

inline std::vector<Vec3> innerPoints(const Shape& shape, int count) {
  return InnerPoints(count)(shape);
}

}  // namespace packmesh
