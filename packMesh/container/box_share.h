// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The part of a small box on one side of a wall.
#pragma once

#include <algorithm>
#include <cmath>

#include "packMesh/container/closed_form_wall.h"

namespace packmesh {

/// Share of a box on the inner side of a plane at this distance from its centre: exact for planes across an
/// axis, otherwise that of a slab as thick as the box is along the normal.
inline double shareInside(const WallDistance& plane, const Vec3& size) {
  if (!std::isfinite(plane.distance)) return 1.0;
  const double thickness = plane.gradient.cwiseAbs().dot(size) / std::max(plane.gradient.norm(), 1e-12);
  return std::clamp(0.5 + plane.distance / thickness, 0.0, 1.0);
}

}  // namespace packmesh
