// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Initial state of growth.
#pragma once

#include <functional>
#include <vector>

#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"
#include "packMesh/relaxation/body.h"

namespace packmesh {

/// Turns placed cells into a valid initial state: cells larger than `smallest` that overlap each other, a
/// fixed cell or the wall are halved until they do not, and the remaining overlaps are resolved by relaxation
/// at those scales. All ranks call; the result does not depend on their number.
/// @param own this rank's cells: fixed ones at scale 1, existing ones at scale 1 or less, all others at
///   `smallest`
/// @return whether the cells are valid now; false: they do not fit even at this scale, or it was stopped
bool seed(const Physics& physics, const Execution& execution, double smallest,
          const std::function<bool()>& stop, std::vector<Body>& own);

}  // namespace packmesh
