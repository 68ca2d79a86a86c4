// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/stages/placement/placement.h"

#include "packMesh/random.h"

namespace packmesh {
namespace {

/// Tries for one cell; where all fail (a lumen that fills a tiny part of its bounds) the best of them is
/// taken.
constexpr std::uint32_t tries = 2000;

}  // namespace

std::vector<Pose> placeRandomly(const PlacementInput& input, const Box& bounds, std::uint64_t seed,
                                bool rotate) {
  std::vector<Pose> poses(input.count);
  const double wanted = input.shape->bound().semiAxes.minCoeff();
  for (std::int64_t i = 0; i < input.count; ++i) {
    const std::uint64_t id = input.firstId + i;
    Pose& pose = poses[i];
    double best = -std::numeric_limits<double>::infinity();
    for (std::uint32_t attempt = 0; attempt < tries && best < wanted; ++attempt) {
      const auto u = uniform4(seed, RandomStream::position, id, attempt);
      const Vec3 p = bounds.lo + bounds.size().cwiseProduct(Vec3(u[0], u[1], u[2]));
      const double distance = input.wall != nullptr ? input.wall->distance(p).distance : wanted;
      if (distance <= best) continue;
      best = distance;
      pose.position = p;
    }
    if (!rotate) continue;
    const auto u = uniform4(seed, RandomStream::orientation, id, 0);
    pose.orientation = uniformRotation(u[0], u[1], u[2]);
  }
  return poses;
}

}  // namespace packmesh
