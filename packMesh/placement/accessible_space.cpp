// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/placement/accessible_space.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>
#include <utility>

#include "packMesh/core/grid_key.h"
#include "packMesh/mesh/joined_sets.h"
#include "packMesh/shape/sample_points.h"

namespace packmesh {
namespace {

/// Longest edge of the smallest parts [half thicknesses of the cell], and number of parts above which the
/// space is given up.
constexpr double finest = 1.0;
constexpr std::int64_t mostParts = 2000000;

/// The same for points [µm].
constexpr double finestOfPoints = 0.4;

/// Cells of the grid by which components are found, at most.
constexpr double mostGridCells = 4e6;

/// Parts that a thread examines at once.
constexpr std::int64_t partsAtOnce = 64;

/// Orientations that are tried: for a body of revolution in a tube, one of them is within 13 degrees of the
/// best.
constexpr int orientationsTried = 32;

/// Points of the surface that are tested: those farthest apart.
constexpr int pointsTested = 48;

/// Orientations of parts other than one of those tried.
constexpr std::int16_t anyOrientation = -1, nowhere = -2, undecided = -3;

/// Axes evenly spread over a half-sphere, each with another rotation about it.
std::vector<Quaternion> spreadOrientations(const std::optional<AxisCone>& cone) {
  constexpr double golden = 2.39996322972865332;  // angle [rad]
  std::vector<Quaternion> orientations;
  for (int i = 0; i < orientationsTried; ++i) {
    const double y = (i + 0.5) / orientationsTried, r = std::sqrt(1.0 - y * y);
    const Vec3 axis(r * std::cos(golden * i), y, r * std::sin(golden * i));
    const Quaternion turn(Eigen::AngleAxisd(golden * i, Vec3::UnitY()));
    const Quaternion orientation = (Quaternion::FromTwoVectors(Vec3::UnitY(), axis) * turn).normalized();
    orientations.push_back(cone ? cone->nearest(orientation) : orientation);
  }
  return orientations;
}

/// Appends the parts of a part, whose edges become as equal as halving can make them.
void divide(const AccessibleSpace::Part& part, std::vector<AccessibleSpace::Part>& into) {
  const float longest = part.half.maxCoeff();
  std::array<int, 3> steps;
  AccessibleSpace::Part child = part;
  for (int k = 0; k < 3; ++k) {
    steps[k] = part.half[k] > 0.7f * longest ? 2 : 1;
    if (steps[k] == 2) child.half[k] *= 0.5f;
  }
  for (int z = 0; z < steps[2]; ++z)
    for (int y = 0; y < steps[1]; ++y)
      for (int x = 0; x < steps[0]; ++x) {
        const Vec3 at(x, y, z);
        child.centre = part.centre;
        for (int k = 0; k < 3; ++k)
          if (steps[k] == 2) child.centre[k] += (2.0 * at[k] - 1.0) * double(child.half[k]);
        into.push_back(child);
      }
}

}  // namespace

/// Whether a cell fits at a place, by points of its surface.
class CellFit {
 public:
  CellFit(const Physics& physics, int s)
      : radius(physics.shapeOf(physics.species[s]).radius()),
        thin(physics.shapeOf(physics.species[s]).bound().semiAxes.minCoeff()),
        longestEdge(finest * thin),
        freedom_(physics.species[s].freedom),
        clearance_(physics.wallClearanceOf(s)),
        bounds_(physics.container->bounds()),
        period_(physics.container->period()),
        exact_(*physics.wallOf(s)),
        wall_(exact_.coarselySampled(physics.surroundings())),
        points_(spreadPoints(physics.shapeOf(physics.species[s]).mesh(), pointsTested)),
        orientations_(physics.rotate ? spreadOrientations(freedom_.cone)
                                     : std::vector<Quaternion>{Quaternion::Identity()}) {
    if (freedom_.freeLayer) layer_ = &freedom_.freeLayer->wall->coarselySampled(physics.surroundings());
  }

  /// Of points.
  explicit CellFit(const Container& container)
      : radius(0.0),
        thin(0.0),
        longestEdge(finestOfPoints),
        clearance_(0.0),
        bounds_(container.bounds()),
        period_(container.period()),
        exact_(*container.wall()),
        wall_(exact_.coarselySampled(container.surroundings(0.0))),
        points_(1, Vec3::Zero()),
        orientations_(1, Quaternion::Identity()) {}

  const double radius, thin;  ///< of the cell [µm]
  const double longestEdge;   ///< of the smallest parts [µm]

  const std::vector<Quaternion>& orientations() const { return orientations_; }

  /// The image of a point in the bounds.
  Vec3 within(Vec3 p) const {
    for (int k = 0; k < 3; ++k)
      if (period_[k] > 0.0) p[k] -= period_[k] * std::floor((p[k] - bounds_.lo[k]) / period_[k]);
    return p;
  }
  /// Depth of a point in the space that membranes may be in [µm].
  double depth(const Vec3& p) const {
    const Vec3 at = within(p);
    const double depth = wall_.sample(at).distance - clearance_;
    return layer_ ? std::min(depth, layer_->sample(at).distance - freedom_.freeLayer->thickness) : depth;
  }
  /// The same at the centre of a part with this reach, without samples if it is large: those far from walls
  /// are dear [µm].
  double depthOf(const Vec3& p, double reach) const {
    if (reach < farReach * wall_.spacing()) return depth(p);
    const Vec3 at = within(p);
    const double depth = exact_.distance(at).distance - clearance_;
    return layer_ ? std::min(depth,
                             freedom_.freeLayer->wall->distance(at).distance - freedom_.freeLayer->thickness)
                  : depth;
  }
  /// Depth of a point in the region of centres [µm].
  double depthInRegion(const Vec3& p) const {
    return freedom_.region ? freedom_.region->distance(p).distance : std::numeric_limits<double>::infinity();
  }

  bool fits(const Vec3& centre, const Quaternion& orientation) const {
    const Mat3 turn = orientation.toRotationMatrix();
    return std::all_of(points_.begin(), points_.end(),
                       [&](const Vec3& point) { return depth(centre + turn * point) >= 0.0; });
  }
  /// The first orientation in which it fits, and with its centre in the region; `nowhere`: none.
  std::int16_t orientationAt(const Vec3& centre) const {
    if (depthInRegion(centre) < 0.0 || depth(centre) < 0.0) return nowhere;
    for (std::size_t i = 0; i < orientations_.size(); ++i)
      if (fits(centre, orientations_[i])) return std::int16_t(i);
    return nowhere;
  }

 private:
  static constexpr double farReach = 2.0;  ///< [spacings of the samples]

  Freedom freedom_;
  double clearance_;  ///< [µm]
  Box bounds_;
  Vec3 period_;
  const Wall& exact_;
  const SampledDistance& wall_;
  const SampledDistance* layer_ = nullptr;
  std::vector<Vec3> points_;
  std::vector<Quaternion> orientations_;
};

AccessibleSpace::AccessibleSpace(const Physics& physics, int species, const Threads& threads)
    : fit_(std::make_unique<CellFit>(physics, species)) {
  Box room = physics.container->bounds();
  if (const auto& region = physics.species[species].freedom.region) {
    room.lo = room.lo.cwiseMax(region->bounds().lo);
    room.hi = room.hi.cwiseMin(region->bounds().hi);
  }
  find(room, threads);
}

AccessibleSpace::AccessibleSpace(const Container& container, const Threads& threads)
    : fit_(std::make_unique<CellFit>(container)) {
  find(container.bounds(), threads);
}

void AccessibleSpace::find(const Box& room, const Threads& threads) {
  if (room.empty()) return;
  /// Whether a cell fits nowhere or anywhere in a part, as far as the depth of its centre tells.
  const auto examined = [&](const Part& part) {
    const double reach = double(part.half.norm()), inRegion = fit_->depthInRegion(part.centre);
    if (inRegion + reach < 0.0) return nowhere;
    const double depth = fit_->depthOf(part.centre, reach);
    if (depth + reach < fit_->thin) return nowhere;
    return depth - reach >= fit_->radius && inRegion >= reach ? anyOrientation : undecided;
  };
  std::vector<Part> parts = {{room.center(), (0.5 * room.size()).cast<float>(), undecided}}, divided;
  const auto forEach = [&](const auto& decide) {
    threads.forEachPart(
        std::int64_t(parts.size()),
        [&](std::int64_t begin, std::int64_t end, int) {
          for (std::int64_t i = begin; i < end; ++i)
            if (parts[i].orientation == undecided) parts[i].orientation = decide(parts[i]);
        },
        partsAtOnce);
    parts.erase(
        std::remove_if(parts.begin(), parts.end(), [](const Part& p) { return p.orientation == nowhere; }),
        parts.end());
  };
  while (true) {
    forEach(examined);
    const auto isLarge = [&](const Part& part) {
      return part.orientation == undecided && 2.0 * double(part.half.maxCoeff()) > fit_->longestEdge;
    };
    const std::int64_t large = std::count_if(parts.begin(), parts.end(), isLarge);
    complete_ = 8 * large <= mostParts;
    if (large == 0 || !complete_) break;
    divided.clear();
    for (const Part& part : parts)
      if (isLarge(part))
        divide(part, divided);
      else
        divided.push_back(part);
    parts.swap(divided);
  }
  forEach([&](const Part& part) { return fit_->orientationAt(part.centre); });
  parts_ = std::move(parts);
  double sum = 0.0;
  for (const Part& part : parts_) ends_.push_back(sum += part.volume());
}

AccessibleSpace::~AccessibleSpace() = default;

std::vector<double> AccessibleSpace::apart() const {
  // On a grid as fine as the smallest boxes, unless that has too many cells.
  Box box;
  Eigen::Vector3f least = Eigen::Vector3f::Constant(std::numeric_limits<float>::infinity());
  for (const Part& part : parts_) {
    least = least.cwiseMin(part.half);
    box.add(part.centre - part.half.cast<double>());
    box.add(part.centre + part.half.cast<double>());
  }
  if (parts_.empty()) return {};
  Vec3 edge = 2.0 * least.cast<double>();
  edge *= std::max(1.0, std::cbrt(volume() / edge.prod() / mostGridCells));
  const auto cellOf = [&](const Vec3& p) { return gridIndex(p - box.lo, edge); };
  JoinedSets joined(parts_.size());
  struct Occupied {
    GridIndex cell;
    int part;
  };
  std::unordered_map<std::int64_t, Occupied> occupied;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Vec3 inner = 0.999 * parts_[i].half.cast<double>();
    const auto lo = cellOf(parts_[i].centre - inner), hi = cellOf(parts_[i].centre + inner);
    for (std::int64_t z = lo[2]; z <= hi[2]; ++z)
      for (std::int64_t y = lo[1]; y <= hi[1]; ++y)
        for (std::int64_t x = lo[0]; x <= hi[0]; ++x) {
          const GridIndex cell = {x, y, z};
          const auto [found, isNew] = occupied.insert({keyOf(cell), {cell, int(i)}});
          if (!isNew) joined.join(found->second.part, int(i));
        }
  }
  for (const auto& [key, one] : occupied)
    for (int k = 0; k < 3; ++k) {
      Vec3 beside(double(one.cell[0]) + 0.5, double(one.cell[1]) + 0.5, double(one.cell[2]) + 0.5);
      beside[k] += 1.0;
      const Vec3 at = fit_->within(box.lo + edge.cwiseProduct(beside));
      if (const auto next = occupied.find(keyOf(cellOf(at))); next != occupied.end())
        joined.join(one.part, next->second.part);
    }
  std::map<int, double> volumes;
  for (std::size_t i = 0; i < parts_.size(); ++i)
    volumes[joined.first(int(i))] += parts_[i].volume() / volume();
  std::vector<double> shares;
  for (const auto& [set, share] : volumes) shares.push_back(share);
  std::sort(shares.rbegin(), shares.rend());
  return shares;
}

std::optional<Pose> AccessibleSpace::fitting(const Vec3& centre, const Quaternion& wanted) const {
  if (fit_->depthInRegion(centre) < 0.0 || fit_->depth(centre) < 0.0) return {};
  if (fit_->fits(centre, wanted)) return Pose{1.0, wanted, centre};
  const std::int16_t orientation = fit_->orientationAt(centre);
  if (orientation == nowhere) return {};
  return Pose{1.0, fit_->orientations()[orientation], centre};
}

Pose AccessibleSpace::pose(double at, const std::array<double, 4>& within, const Quaternion& wanted) const {
  const auto found = std::upper_bound(ends_.begin(), ends_.end(), at * volume());
  const Part& part = parts_[std::min<std::size_t>(found - ends_.begin(), parts_.size() - 1)];
  Pose pose;
  const Vec3 offset = Vec3(within[0], within[1], within[2]) - Vec3::Constant(0.5);
  pose.position = part.centre + 2.0 * part.half.cast<double>().cwiseProduct(offset);
  pose.orientation = wanted;
  if (part.orientation == anyOrientation) return pose;
  if (fit_->depthInRegion(pose.position) < 0.0) pose.position = part.centre;
  if (fit_->fits(pose.position, wanted)) return pose;
  pose.orientation = fit_->orientations()[part.orientation];
  if (!fit_->fits(pose.position, pose.orientation)) pose.position = part.centre;
  return pose;
}

AccessibleSpaces::AccessibleSpaces(const Physics& physics, const Threads& threads)
    : physics_(physics), threads_(threads), made_(physics.species.size()) {}

const AccessibleSpace* AccessibleSpaces::of(int species) {
  const Wall* const wall = physics_.wallOf(species);
  if (!wall || wall->closedForm()) return nullptr;
  std::unique_ptr<const AccessibleSpace>& space = made_[species];
  if (!space) space = std::make_unique<const AccessibleSpace>(physics_, species, threads_);
  return space->complete() && space->volume() > 0.0 ? space.get() : nullptr;
}

}  // namespace packmesh
