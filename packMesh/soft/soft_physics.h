// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What soft cells keep to, and the undeformed cells as which they begin.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "packMesh/problem/physics.h"

namespace packmesh {

/// Distance beyond the least that a wall demands, or a lower bound of it, and its gradient. Called by several
/// threads.
using WallGap = std::function<WallDistance(const Vec3&)>;

/// That of a species to its wall and its layer without cells; nothing if it has neither.
/// @param physics must outlive the result
std::optional<WallGap> wallGapOf(const Physics& physics, int species);

/// The physics of undeformed cells at a scale, apart from those that do not grow. They keep so far from a wall
/// that its WallGap is positive, apart from smoothed ones.
/// @param gap added to the clearances [µm]
/// @param ofSmoothed distance that is kept from the wall where they keep to smoothed ones [their reach]
Physics scaledPhysics(const Physics& physics, const std::vector<char>& grows, double scale, double gap,
                      double ofSmoothed);

}  // namespace packmesh
