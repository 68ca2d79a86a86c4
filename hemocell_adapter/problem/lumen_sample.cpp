// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/lumen_sample.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <unordered_map>
#include <utility>

#include "hemocell_adapter/problem/parts.h"
#include "packMesh/core/grid_key.h"
#include "packMesh/placement/placement.h"

namespace packmesh::hemocell {
namespace {

/// Packings are less dense along walls, as if a layer of this thickness were empty [µm]: at a smooth wall,
/// and at the faces of the nodes that HemoCell excludes, between which membranes can protrude.
constexpr double emptyLayer = 0.55, emptyLayerAtNodes = 0.40;

/// Number of points at which the distance to walls is sampled.
constexpr int points = 12000;

/// Where cells can be is larger than the volume of a vessel by the continuation of its ends; smaller
/// differences are those of the sample.
constexpr double leastContinuation = 1.02;

/// Maximum number of points from which a cell is tried.
constexpr std::size_t trials = 8;

/// Smaller parts of a space are those of its resolution.
constexpr double leastPart = 0.002;

/// Narrower places are not worth telling [µm]: blood has no smaller vessels.
constexpr double leastWidth = 2.0;

/// Whether points are near a space.
class Nearness {
 public:
  Nearness(const AccessibleSpace& space, double reach) : reach_(reach) {
    for (const AccessibleSpace::Part& part : space.parts()) {
      const Vec3 half = part.half.cast<double>();
      const GridIndex lo = cellOf(part.centre - half - Vec3::Constant(reach)),
                      hi = cellOf(part.centre + half + Vec3::Constant(reach));
      for (std::int64_t z = lo[2]; z <= hi[2]; ++z)
        for (std::int64_t y = lo[1]; y <= hi[1]; ++y)
          for (std::int64_t x = lo[0]; x <= hi[0]; ++x)
            parts_[keyOf({x, y, z})].push_back({part.centre - half, part.centre + half});
    }
  }
  bool operator()(const Vec3& p) const {
    const auto found = parts_.find(keyOf(cellOf(p)));
    return found != parts_.end() &&
           std::any_of(found->second.begin(), found->second.end(),
                       [&](const Box& part) { return part.squaredDistance(p) <= reach_ * reach_; });
  }

 private:
  GridIndex cellOf(const Vec3& p) const { return gridIndex(p, Vec3::Constant(2.0 * reach_)); }

  double reach_;  ///< [µm]
  std::unordered_map<std::int64_t, std::vector<Box>> parts_;
};

}  // namespace

void LumenSample::draw() {
  const Container& container = *problem_.lumen.container;
  wall_ = container.wall();
  volume_ = container.volume();
  if (!wall_) return;
  if (wall_->closedForm())
    drawFromBounds(container.bounds());
  else
    drawFrom(AccessibleSpace(container, problem_.team));
}

void LumenSample::drawFromBounds(const Box& bounds) {
  for (std::uint64_t i = 0; i < std::uint64_t(points); ++i) {
    const Vec3 p = bounds.lo + bounds.size().cwiseProduct(evenPoint({0.5, 0.5, 0.5, 0.5}, i + 1));
    const double distance = wall_->distance(p).distance;
    if (distance < 0.0) continue;
    inside_.push_back(p);
    distances_.push_back(distance);
  }
}

void LumenSample::drawFrom(const AccessibleSpace& lumen) {
  if (lumen.volume() > leastContinuation * volume_) volume_ = lumen.volume();
  for (std::uint64_t i = 0; i < std::uint64_t(points) && lumen.volume() > 0.0; ++i) {
    const Vec3 within = evenPoint({0.5, 0.5, 0.5, 0.5}, i + 1);
    const Vec3 p =
        lumen.pose(evenShare(0.5, i), {within[0], within[1], within[2], 0.0}, Quaternion::Identity())
            .position;
    inside_.push_back(p);
    distances_.push_back(wall_->distance(p).distance);
  }
}

const Room& LumenSample::room(int species) {
  if (volume_ == 0.0) draw();
  const auto [found, isNew] = rooms_.try_emplace(species);
  if (isNew) found->second = measured(species);
  return found->second;
}

Room LumenSample::measured(int s) const {
  Room room;
  room.volume = room.effective = volume_;
  if (!wall_) return room;
  const PackedParts& packed = problem_.atDemanded;
  const double clearance = problem_.species[s].wallClearance(packed.clearances.wall);
  const Wall* const nodes = packed.walls[s].get();
  const Shape& shape = *problem_.species[s].shape;
  std::function<bool(const Vec3&)> reaches;
  if (!wall_->closedForm() || (nodes && !nodes->closedForm())) {
    Physics physics;
    physics.species = {freeCells(problem_, packed, s, 1)};
    physics.shapes = problem_.shapes;
    physics.container = problem_.lumen.container;
    physics.wallClearance = packed.clearances.wall;
    physics.rotate = problem_.request.rotate;
    const AccessibleSpace space(physics, 0, problem_.team);
    if (space.complete()) {
      for (const double share : space.apart())
        if (share >= leastPart) room.apart.push_back(share);
      const auto near = std::make_shared<Nearness>(space, shape.radius());
      reaches = [near](const Vec3& p) { return (*near)(p); };
    }
  }
  std::vector<std::pair<double, std::size_t>> depths;
  std::size_t bodies = 0, effective = 0;
  for (std::size_t i = 0; i < inside_.size(); ++i) {
    const double smooth = distances_[i] - clearance;
    const double depth = nodes ? nodes->distance(inside_[i]).distance - clearance : smooth;
    depths.emplace_back(depth, i);
    if (depth < 0.0) continue;
    if (reaches && !reaches(inside_[i])) {
      const double width = 2.0 * distances_[i];
      if (width >= std::max(leastWidth, room.narrow ? room.narrow->width : 0.0))
        room.narrow = {inside_[i], width};
      continue;
    }
    ++bodies;
    effective += depth >= (nodes ? emptyLayerAtNodes : emptyLayer) && smooth >= emptyLayer;
  }
  const double all = std::max<double>(1.0, double(inside_.size()));
  room.share = double(bodies) / all;
  room.volume = room.share * volume_;
  room.effective = double(effective) / all * volume_;
  const std::size_t some = std::min(trials, depths.size());
  std::partial_sort(depths.begin(), depths.begin() + std::ptrdiff_t(some), depths.end(), std::greater<>());
  for (std::size_t k = 0; k < some; ++k) room.deepest.push_back(inside_[depths[k].second]);
  return room;
}

}  // namespace packmesh::hemocell
