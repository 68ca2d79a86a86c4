// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/problem/physics.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace packmesh {
namespace {

/// Interpolated distances to an edge of the wall are too large by at most this [spacings].
constexpr double interpolationExcess = 0.26;

/// By how much distances of a wall may be too large [µm].
double excessOf(const Wall& wall, const Box& region) {
  if (wall.closedForm()) return 0.0;
  return wall.slack() + interpolationExcess * wall.sampled(region).spacing();
}

/// The wall of a species, as what is left to it beyond the gap that it demands.
WallGap gapFrom(const Wall& wall, double demanded, const Box& region) {
  const auto beyond = [](double gap, auto distance) {
    return [=](const Vec3& p) {
      WallDistance at = distance(p);
      at.distance -= gap;
      return at;
    };
  };
  if (const auto form = wall.closedForm())
    return beyond(demanded, [form = *form](const Vec3& p) { return form.distance(p); });
  return beyond(demanded + excessOf(wall, region),
                [samples = &wall.sampled(region)](const Vec3& p) { return samples->sample(p); });
}

}  // namespace

double AxisCone::angle(const Quaternion& orientation) const {
  const Vec3 own = orientation * Vec3::UnitY();
  return std::atan2(own.cross(axis).norm(), std::abs(own.dot(axis)));
}

Quaternion AxisCone::nearest(const Quaternion& orientation) const {
  const double beyond = angle(orientation) - spread;
  if (!(beyond > 0.0)) return orientation;
  const Vec3 own = orientation * Vec3::UnitY();
  const Vec3 towards = own.dot(axis) < 0.0 ? Vec3(-axis) : axis;
  Vec3 around = own.cross(towards);
  if (!(around.norm() > 1e-12)) return orientation;  // parallel: rotation axis undefined
  return (Quaternion::around(around.normalized(), beyond) * orientation).normalized();
}

std::int64_t Species::placed() const {
  const auto isGiven = [](const DeformedCell& cell) { return cell.start.has_value(); };
  return std::count_if(deformed.begin(), deformed.end(), isGiven) + std::int64_t(start.size());
}

bool Species::startsAtGivenPose(std::int64_t cell) const {
  const auto first = std::int64_t(deformed.size());
  if (cell < first) return deformed[cell].start.has_value();
  return inColumns || cell - first < std::int64_t(start.size());
}

void Species::resize(std::int64_t cells) {
  count = cells;
  deformed.resize(std::min<std::size_t>(deformed.size(), cells));
  start.resize(std::min<std::size_t>(start.size(), undeformed()));
}

Species& Physics::add(std::string name, std::shared_ptr<const Shape> shape, std::int64_t count) {
  shapes.push_back(std::move(shape));
  return species.emplace_back(Species{std::move(name), int(shapes.size()) - 1, count, nullptr});
}

bool Physics::hasDeformed() const {
  return std::any_of(shapes.begin(), shapes.end(), [](const auto& shape) { return shape->undeformed(); });
}

bool Physics::areOfCell(std::int64_t ofSpecies, std::int64_t shape) const {
  if (ofSpecies < 0 || ofSpecies >= std::int64_t(species.size())) return false;
  if (shape < 0 || shape >= std::int64_t(shapes.size())) return false;
  const int undeformed = species[ofSpecies].shape;
  return shape == undeformed || shapes[shape]->undeformed() == shapes[undeformed];
}

std::vector<int> Physics::shapesInUse() const {
  std::vector<int> used;
  for (const Species& one : species)
    one.forEachShape([&](int shape, std::int64_t) { used.push_back(shape); });
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  return used;
}

double Physics::largest(double (Shape::*length)() const) const {
  double most = 0.0;
  for (const int shape : shapesInUse()) most = std::max(most, (*shapes[shape].*length)());
  return most;
}

double meanVolume(const Species& species, const Shapes& shapes) {
  if (species.deformed.empty()) return shapes[species.shape]->volume();
  double volume = 0.0;
  species.forEachShape([&](int shape, std::int64_t n) { volume += double(n) * shapes[shape]->volume(); });
  return volume / double(species.count);
}

void deform(std::vector<PlacedCell>& cells, const std::map<std::size_t, std::vector<Vec3>>& vertices,
            Shapes& shapes, const Communicator& ranks) {
  const auto templateOf = [&](int shape) {
    const std::shared_ptr<const Shape>& undeformed = shapes[shape]->undeformed();
    return undeformed ? undeformed : shapes[shape];
  };
  std::vector<std::int32_t> formOf;  // the shape that each new one is a form of
  std::vector<std::vector<Vec3>> all;
  auto next =
      std::int32_t(shapes.size() + std::size_t(ranks.sumBefore({std::int64_t(vertices.size())}).front()));
  for (const auto& [cell, own] : vertices) {
    formOf.push_back(std::exchange(cells[cell].shape, next++));
    all.push_back(own);
  }
  formOf = ranks.gatherAll(formOf);
  all = ranks.gatherRows(all);
  for (std::size_t i = 0; i < all.size(); ++i)
    shapes.push_back(std::make_shared<const Shape>(std::move(all[i]), templateOf(formOf[i])));
}

std::optional<WallGap> wallGapOf(const Physics& physics, int s) {
  const Box region = physics.surroundings();
  std::optional<WallGap> gap;
  const Wall* const wall = physics.wallOf(s);
  if (physics.smoothReachOf(s) > 0.0)
    gap = [wall](const Vec3& p) { return wall->smoothed(p); };
  else if (wall)
    gap = gapFrom(*wall, physics.wallClearanceOf(s), region);
  if (const auto& layer = physics.species[s].freedom.freeLayer) {
    const WallGap other = gapFrom(*layer->wall, layer->thickness, region);
    gap = !gap ? other : [a = *gap, other](const Vec3& p) {
      const WallDistance first = a(p), second = other(p);
      return first.distance < second.distance ? first : second;
    };
  }
  return gap;
}

Physics scaledPhysics(const Physics& physics, const std::vector<char>& grows, double scale, double gap,
                      double ofSmoothed) {
  Physics small = physics;
  small.clearance += gap;
  small.wallClearance += gap;
  std::map<const Shape*, std::shared_ptr<const Shape>> made;
  const auto madeOf = [&](const std::shared_ptr<const Shape>& shape) {
    std::shared_ptr<const Shape>& out = made[shape.get()];
    if (!out) out = std::make_shared<const Shape>(*shape, scale);
    return out;
  };
  // Shapes can be shared with species that do not grow: small ones have numbers of their own.
  std::map<int, int> smallOf;
  const auto smallShape = [&](int shape) {
    const auto [at, isNew] = smallOf.try_emplace(shape, int(small.shapes.size()));
    if (!isNew) return at->second;
    const auto& undeformed = physics.shapes[shape]->undeformed();
    small.shapes.push_back(
        undeformed ? std::make_shared<const Shape>(scaledBy(scale, physics.shapes[shape]->mesh().vertices),
                                                   madeOf(undeformed))
                   : madeOf(physics.shapes[shape]));
    return at->second;
  };
  for (std::size_t s = 0; s < small.species.size(); ++s) {
    if (!grows[s] || scale == 1.0) continue;
    Species& species = small.species[s];
    const Box region = physics.surroundings();
    if (const Wall* wall = physics.wallOf(int(s)))
      species.freedom.extraWallClearance +=
          std::max(ofSmoothed * physics.smoothReachOf(int(s)), excessOf(*wall, region));
    if (auto& layer = species.freedom.freeLayer) layer->thickness += gap + excessOf(*layer->wall, region);
    species.shape = smallShape(species.shape);
    for (DeformedCell& cell : species.deformed) cell.shape = smallShape(cell.shape);
  }
  small.written = {};
  return small;
}

}  // namespace packmesh
