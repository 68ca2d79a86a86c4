// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Volume of the part of a box on one side of a wall.
#pragma once

#include <algorithm>
#include <cmath>

#include "packMesh/container/closed_form_wall.h"

namespace packmesh {

/// Fraction of a box on the inner side of a plane at this distance from its centre: exact for planes
/// perpendicular to an axis; otherwise that of a slab as thick as the box is along the normal.
inline double shareInside(const WallDistance& plane, const Vec3& size) {
  if (!std::isfinite(plane.distance)) return 1.0;
  const double thickness = plane.gradient.cwiseAbs().dot(size) / std::max(plane.gradient.norm(), 1e-12);
  return std::clamp(0.5 + plane.distance / thickness, 0.0, 1.0);
}

/// Volume of the part of a box on the inner side of surfaces [µm³]: 0 or all of it if no surface can cut the
/// box, the sum over its octants if it can still be halved, an estimate otherwise.
/// @param nearest distance to the nearest surface from the centre of the box
/// @param reach distance from the centre within which a surface could cut the box [µm]
/// @param depth number of times the box can still be halved
/// @param ofPart (octant, depth) -> volume
template <class OfPart>
double volumeByHalving(const Box& box, const WallDistance& nearest, double reach, int depth,
                       const OfPart& ofPart) {
  if (nearest.distance < -reach) return 0.0;
  if (nearest.distance > reach || depth == 0) return box.volume() * shareInside(nearest, box.size());
  const Vec3 center = box.center();
  double volume = 0.0;
  for (int octant = 0; octant < 8; ++octant) {
    Box part = box;
    for (int k = 0; k < 3; ++k) ((octant >> k & 1) ? part.lo : part.hi)[k] = center[k];
    volume += ofPart(part, depth - 1);
  }
  return volume;
}

}  // namespace packmesh
