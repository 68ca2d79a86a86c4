// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Exact wall test of convex lumens.
#pragma once

#include <algorithm>
#include <limits>

#include "packMesh/container/container.h"

namespace packmesh {

/// Tests a cell in a convex lumen: it is inside if its vertices are, and its gap to the wall is that of the
/// nearest vertex.
/// @param inside true if a point is in the lumen and not on its wall; a computation with rounding errors must
/// return false in case of doubt
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
