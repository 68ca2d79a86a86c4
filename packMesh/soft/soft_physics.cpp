// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/soft_physics.h"

#include <algorithm>
#include <map>
#include <memory>
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
