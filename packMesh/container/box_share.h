// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The part of a box on one side of a wall.
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

/// Volume of the part of a box on the inner side of surfaces: none or all of it where they are out of reach,
/// the sum over its octants where it may still be halved, an estimate elsewhere.
/// @param nearest of the surfaces, seen from the centre of the box
/// @param reach from the centre, within which a surface may cut the box
/// @param depth the box may be halved so often
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
