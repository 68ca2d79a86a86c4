// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/closed_form_wall.h"

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

}  // namespace packmesh
