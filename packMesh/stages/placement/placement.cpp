// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/stages/placement/placement.h"

#include <algorithm>
#include <cmath>

#include "packMesh/random.h"

namespace packmesh {
namespace {

/// Tries for one cell; where all fail (a lumen that fills a tiny part of its bounds) the best of them is
/// taken.
constexpr std::uint32_t tries = 2000;

/// Axis uniform over the cone, any turn about it, from three uniform numbers.
Quaternion withinCone(const AxisCone& cone, double u, double v, double w) {
  constexpr double twoPi = 6.283185307179586;
  const double c = 1.0 - u * (1.0 - std::cos(cone.spread)), s = std::sqrt(std::max(0.0, 1.0 - c * c));
  const Quaternion tilt =
      Quaternion::FromTwoVectors(Vec3::UnitY(), Vec3(s * std::cos(twoPi * v), c, s * std::sin(twoPi * v)));
  const Quaternion toAxis = Quaternion::FromTwoVectors(Vec3::UnitY(), cone.axis);
  const Quaternion turn(Eigen::AngleAxisd(twoPi * w, Vec3::UnitY()));
  return cone.nearest((toAxis * tilt * turn).normalized());
}

}  // namespace

std::vector<Pose> placeRandomly(const PlacementInput& input, const Box& bounds, std::uint64_t seed,
                                bool rotate) {
  std::vector<Pose> poses(input.count);
  const Region* home = input.freedom ? input.freedom->home.get() : nullptr;
  const AxisCone* cone = input.freedom && input.freedom->cone ? &*input.freedom->cone : nullptr;
  const Box& room = home ? home->bounds() : bounds;
  const double wanted = input.shape->bound().semiAxes.minCoeff();
  for (std::int64_t i = 0; i < input.count; ++i) {
    const std::uint64_t id = input.firstId + i;
    Pose& pose = poses[i];
    double best = -std::numeric_limits<double>::infinity();
    for (std::uint32_t attempt = 0; attempt < tries && best < wanted; ++attempt) {
      const auto u = uniform4(seed, RandomStream::position, id, attempt);
      const Vec3 p = room.lo + room.size().cwiseProduct(Vec3(u[0], u[1], u[2]));
      double distance = input.wall != nullptr ? input.wall->distance(p).distance : wanted;
      if (home) distance = std::min(distance, wanted + std::min(home->distance(p).distance, 0.0));
      if (distance <= best) continue;
      best = distance;
      pose.position = p;
    }
    if (!rotate) continue;
    const auto u = uniform4(seed, RandomStream::orientation, id, 0);
    pose.orientation = cone ? withinCone(*cone, u[0], u[1], u[2]) : uniformRotation(u[0], u[1], u[2]);
  }
  return poses;
}

}  // namespace packmesh
