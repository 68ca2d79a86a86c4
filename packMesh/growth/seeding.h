// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Where growth begins.
#pragma once

#include <functional>
#include <vector>

#include "packMesh/growth/growth_scene.h"

namespace packmesh {

/// Makes placed cells a valid first state: cells larger than `smallest` that meet each other, a fixed cell or
/// the wall are halved until they do not, and what is left is resolved by relaxation at those scales. All
/// ranks call; the result does not depend on their number.
/// @param own this rank's cells: fixed ones at scale 1, those that exist at scale 1 or less, all others at
///   `smallest`
/// @return whether the cells are valid now; false: even so small they do not fit, or it was stopped
bool seed(const GrowthScene& scene, double smallest, const std::function<bool()>& stop,
          std::vector<Body>& own);

}  // namespace packmesh
