// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/placement/placement.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "packMesh/core/random.h"
#include "packMesh/placement/accessible_space.h"

namespace packmesh {
namespace {

/// Number of tries per cell; if all fail (a lumen that fills a tiny part of its bounds), the best one is
/// used.
constexpr std::uint32_t tries = 2000;

/// A space that is less than this share of its bounds is drawn from at once.
constexpr double sparse = 0.2;

/// Poses that are drawn from the accessible space until one does not meet the wall: only thin plates are
/// overlooked, unless the space is incomplete.
constexpr std::uint32_t drawn = 12, drawnFromIncomplete = 100;

/// Cells between two polls: a fraction of a second even if all tries fail.
constexpr std::int64_t betweenPolls = 100;

/// The first tries use a quasirandom sequence, which has fewer clusters and holes than independent points, so
/// that cells have to move less: at a volume fraction of 0.35 this saves a quarter of the sweeps, at 0.55 a
/// twentieth.
constexpr std::uint32_t evenTries = 8;

/// Position at which to try to place the centre of a cell.
Vec3 centre(const Box& room, double volume, std::uint64_t seed, std::uint64_t id, std::uint32_t attempt) {
  const auto u = uniform4(seed, RandomStream::position, id, attempt);
  Vec3 at(u[0], u[1], u[2]);
  if (attempt < evenTries) {
    const Vec3 reach = 2.0 * jitter * std::cbrt(volume) * room.size().cwiseInverse();
    const auto begin = uniform4(seed, RandomStream::begin, 0, attempt);  // of every try its own
    at = evenPoint(begin, id, (at - Vec3::Constant(0.5)).cwiseProduct(reach));
  }
  return room.lo + room.size().cwiseProduct(at);
}

/// Axis uniform over the cone, with a uniform rotation about it, from three uniform numbers.
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

Vec3 evenPoint(const std::array<double, 4>& begin, std::uint64_t n, const Vec3& offset) {
  constexpr double g = 1.22074408460575947536, step[] = {1.0 / g, 1.0 / (g * g), 1.0 / (g * g * g)};
  Vec3 point;
  for (int k = 0; k < 3; ++k) {
    const double p = begin[k] + static_cast<double>(n) * step[k] + offset[k];
    point[k] = p - std::floor(p);
  }
  return point;
}

double evenShare(double begin, std::uint64_t n) {
  constexpr double golden = 0.618033988749894848;
  const double share = begin + golden * static_cast<double>(n);
  return share - std::floor(share);
}

Quaternion randomOrientation(const std::optional<AxisCone>& cone, double u, double v, double w) {
  return cone ? withinCone(*cone, u, v, w) : uniformRotation(u, v, w);
}

std::vector<Pose> placeRandomly(const Physics& physics, const Execution& execution, int species,
                                int shapeNumber, std::int64_t firstId, std::int64_t count,
                                const AccessibleSpace* space) {
  std::vector<Pose> poses(count);
  const Shape& shape = *physics.shapes[shapeNumber];
  const Wall* wall = physics.wallOf(species);
  const Freedom& freedom = physics.species[species].freedom;
  const Region* region = freedom.region.get();
  const Box room = region ? region->bounds() : physics.container->bounds();
  const double wanted = shape.bound().semiAxes.minCoeff();
  const auto meetsWall = [&](const Pose& pose) {
    return wall->examine({shape.hierarchy(), pose.placement()}, 0.0).violation.has_value();
  };
  const bool inBounds = space && space->volume() > sparse * room.volume();
  const auto placeWithin = [&](std::uint64_t id, Pose& pose) {
    const auto u = uniform4(physics.seed, RandomStream::orientation, id, 0);
    const Quaternion wish =
        physics.rotate ? randomOrientation(freedom.cone, u[0], u[1], u[2]) : Quaternion::Identity();
    for (std::uint32_t attempt = inBounds ? 0 : evenTries; attempt < evenTries; ++attempt) {
      const auto fit = space->fitting(centre(room, shape.volume(), physics.seed, id, attempt), wish);
      if (!fit) continue;
      pose = *fit;
      if (!meetsWall(pose)) return;
    }
    const std::uint32_t last = evenTries + (space->complete() ? drawn : drawnFromIncomplete);
    for (std::uint32_t attempt = evenTries; attempt < last; ++attempt) {
      const auto begin = uniform4(physics.seed, RandomStream::begin, 1, attempt);
      pose = space->pose(evenShare(begin[0], id), uniform4(physics.seed, RandomStream::position, id, attempt),
                         wish);
      if (!meetsWall(pose)) return;
    }
  };
  const auto place = [&](std::int64_t i) {
    const std::uint64_t id = firstId + i;
    Pose& pose = poses[i];
    if (space) return placeWithin(id, pose);
    double best = -std::numeric_limits<double>::infinity();
    for (std::uint32_t attempt = 0; attempt < tries && best < wanted; ++attempt) {
      const Vec3 p = centre(room, shape.volume(), physics.seed, id, attempt);
      double distance = wall != nullptr ? wall->distance(p).distance : wanted;
      if (region) distance = std::min(distance, wanted + std::min(region->distance(p).distance, 0.0));
      if (distance <= best) continue;
      best = distance;
      pose.position = p;
    }
    if (!physics.rotate) return;
    const auto u = uniform4(physics.seed, RandomStream::orientation, id, 0);
    pose.orientation = randomOrientation(freedom.cone, u[0], u[1], u[2]);
  };
  std::atomic<bool> stops{false};
  execution.threads.forEachPart(
      count,
      [&](std::int64_t begin, std::int64_t end, int thread) {
        if (thread == 0 && execution.interrupted && execution.interrupted()) stops = true;
        for (std::int64_t i = begin; i < end && !stops; ++i) place(i);
      },
      betweenPolls);
  return poses;
}

}  // namespace packmesh
