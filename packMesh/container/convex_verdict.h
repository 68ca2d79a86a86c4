// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The exact verdict of walls around convex lumens.
#pragma once

#include <algorithm>
#include <limits>

#include "packMesh/container/container.h"

namespace packmesh {

/// The verdict on a cell in a convex lumen: it is inside when its vertices are, and no nearer to the wall
/// than the nearest of them.
/// @param inside whether a point is in the lumen and certainly not on its wall: where it is computed with
///   rounding errors, they count against the point
template <class Inside>
WallVerdict verdictInConvex(const Wall& wall, const PlacedHierarchy& cell, double gapOfInterest,
                            Inside&& inside) {
  WallVerdict verdict;
  std::size_t within = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < cell.vertexCount(); ++i) {
    const Vec3 v = cell.vertex(i);
    within += inside(v);
    if (gapOfInterest > 0.0) nearest = std::min(nearest, wall.distance(v).distance);
  }
  if (within < cell.vertexCount())
    verdict.violation = within == 0 ? "is outside the lumen" : "meets the wall";
  else if (nearest < gapOfInterest)
    verdict.gap = nearest;
  return verdict;
}

}  // namespace packmesh
