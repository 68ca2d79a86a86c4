// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/container.h"

namespace packmesh {

WallDistance ClosedFormWall::distance(const Vec3& p) const {
  WallDistance nearest{std::numeric_limits<double>::infinity(), Vec3::Zero()};
  if (radius > 0.0) {
    const Vec3 radial = across.cwiseProduct(p - center);
    const double r = radial.norm();
    nearest = {radius - r, -radial};
    if (r > 0.0)
      nearest.gradient /= r;
    else
      nearest.gradient = across.x() > 0.0 ? Vec3::UnitX() : Vec3::UnitY();
  }
  for (int k = 0; k < 3; ++k) {
    if (p[k] - lo[k] < nearest.distance) nearest = {p[k] - lo[k], Vec3::Unit(k)};
    if (hi[k] - p[k] < nearest.distance) nearest = {hi[k] - p[k], -Vec3::Unit(k)};
  }
  return nearest;
}

ClosedFormWall ClosedFormWall::without(const std::array<bool, 3>& axes) const {
  constexpr double endless = std::numeric_limits<double>::infinity();
  ClosedFormWall rest = *this;
  for (int k = 0; k < 3; ++k)
    if (axes[k]) rest.lo[k] = -endless, rest.hi[k] = endless;
  return rest;
}

WallDistance Wall::distanceToSides(const Vec3& p, const std::array<bool, 3>& ends) const {
  const std::optional<ClosedFormWall> form = closedForm();
  return form ? form->without(ends).distance(p) : distance(p);
}

void Wall::sample(const NodeBlock& block, float* distances) const {
  for (int k = 0; k < block.nodes[2]; ++k)
    for (int j = 0; j < block.nodes[1]; ++j)
      for (int i = 0; i < block.nodes[0]; ++i)
        *distances++ = static_cast<float>(distance(block.position(i, j, k)).distance);
}

const SampledDistance& Wall::coarselySampled(const Box& region) const {
  constexpr double about = 1.0;  // [µm]
  const double fine = samplingSpacing();
  return samples_.of(*this, region, fine * std::max(2.0, std::round(about / fine)));
}

const SampledDistance& Wall::Samples::of(const Wall& wall, const Box& region, double spacing) const {
  const std::lock_guard lock(mutex_);
  for (const Made& made : made_)
    if (made.samples->spacing() == spacing && made.region.lo == region.lo && made.region.hi == region.hi)
      return *made.samples;
  made_.push_back({region, std::make_unique<SampledDistance>(wall, region, spacing)});
  return *made_.back().samples;
}

}  // namespace packmesh
