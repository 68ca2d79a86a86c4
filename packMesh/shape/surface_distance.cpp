// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/shape/surface_distance.h"

#include <algorithm>
#include <cmath>

namespace packmesh {
namespace {

/// What stands for a vanishing gradient, which has no direction.
constexpr double flat = 1e-12;

/// From a point as far away as a cell is wide.
constexpr int newtonSteps = 6;

}  // namespace

SurfaceDistance::SurfaceDistance(const Shape& shape)
    : profile_(std::get_if<ProfileSurface>(&shape.field())),
      grid_(std::get_if<DistanceGrid>(&shape.field())),
      ring_(shape.bound().ring),
      thickness_(shape.bound().semiAxes.maxCoeff()) {
  if (profile_) {
    bend_ = profile_->bendBeyondRim();
    curvature_ = profile_->curvatureInside();
  }
  const Box box = boundingBox(shape.mesh());
  extent_ = box.lo.cwiseAbs().cwiseMax(box.hi.cwiseAbs());
}

DistanceSample SurfaceDistance::closedForm(const Vec3& p) const {
  const Level l = level(p);
  const double steep = l.gradient.norm(), half = 0.5 * steep;
  const double curved = std::min(l.value, curvature_ * l.value);
  const double denominator = half + std::sqrt(std::max(half * half - curved, 0.0));
  return {l.value / std::max(denominator, flat), l.gradient / std::max(steep, flat)};
}

DistanceSample SurfaceDistance::interpolated(const Vec3& p) const {
  const DistanceSample s = grid_->sample(p);
  return {s.distance, s.gradient / std::max(s.gradient.norm(), flat)};
}

double SurfaceDistance::lowerBound(const Vec3& p) const {
  const double beyond = std::max(std::sqrt(p.x() * p.x() + p.z() * p.z()) - ring_, 0.0);
  const double rounded = std::sqrt(beyond * beyond + p.y() * p.y()) - thickness_;
  const double boxed = (p.cwiseAbs() - extent_).maxCoeff();
  return std::max(rounded, boxed);
}

Vec3 SurfaceDistance::foot(const Vec3& p, const DistanceSample& sample) const {
  const Vec3 first = p - sample.distance * sample.gradient;
  if (profile_) {
    const Level l = level(first);
    const Vec3 step = l.value / std::max(l.gradient.squaredNorm(), flat) * l.gradient;
    if (step.squaredNorm() < 0.05 * sample.distance * sample.distance) return first - step;
    // So far away the distance is overestimated; Newton's steps come from outside and do not overshoot.
    Vec3 q = p;
    for (int k = 0; k < newtonSteps; ++k) {
      const Level at = level(q);
      q -= at.value / std::max(at.gradient.squaredNorm(), flat) * at.gradient;
    }
    return q;
  }
  const DistanceSample rest = interpolated(first);
  return first - rest.distance * rest.gradient;
}

namespace {

/// Element n of the van der Corput sequence with the given base [fraction].
double vanDerCorput(int n, int base) {
  double value = 0.0, digit = 1.0;
  for (; n > 0; n /= base) value += (n % base) * (digit /= base);
  return value;
}

}  // namespace

std::vector<Vec3> InnerPoints::operator()(const Shape& shape) const {
  const Shape& ofTemplate = shape.undeformed() ? *shape.undeformed() : shape;
  const OfTemplate& there = templates_.at(&ofTemplate, [&] { return made(ofTemplate); });
  std::vector<Vec3> points = there.points;
  if (!shape.undeformed()) return points;
  const std::vector<Vec3>&from = ofTemplate.mesh().vertices, &to = shape.mesh().vertices;
  for (std::size_t i = 0; i < points.size(); ++i) points[i] += to[there.nearest[i]] - from[there.nearest[i]];
  return points;
}

InnerPoints::OfTemplate InnerPoints::made(const Shape& shape) const {
  const SurfaceDistance surface(shape);
  const Box box = boundingBox(shape.mesh());
  OfTemplate out;
  constexpr int patience = 1000;
  for (int n = 1; static_cast<int>(out.points.size()) < count_ && n < patience * count_; ++n) {
    const Vec3 at(vanDerCorput(n, 2), vanDerCorput(n, 3), vanDerCorput(n, 5));
    const Vec3 p = box.lo + at.cwiseProduct(box.size());
    if (surface.sample(p).distance < 0.0) out.points.push_back(p);
  }
  if (out.points.empty()) out.points.push_back(Vec3::Zero());
  const std::vector<Vec3>& vertices = shape.mesh().vertices;
  for (const Vec3& p : out.points) {
    std::size_t nearest = 0;
    for (std::size_t v = 1; v < vertices.size(); ++v)
      if ((vertices[v] - p).squaredNorm() < (vertices[nearest] - p).squaredNorm()) nearest = v;
    out.nearest.push_back(nearest);
  }
  return out;
}

}  // namespace packmesh
