// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Relaxations of growing cells: of the first state, and of those that stall.
#pragma once

#include <functional>
#include <vector>

#include "packMesh/cat/growing_cells.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"
#include "packMesh/relaxation/body.h"
#include "packMesh/relaxation/relaxation.h"

namespace packmesh {

/// Relaxes cells, enlarged to at least `scale`, as rigid bodies for at most the given number of sweeps: the
/// contact relaxation of the default method, with all constraints. If the exact test finds the
/// result free of overlap, repaired where needed, it replaces the cells. All ranks call.
/// @return whether the cells were replaced; if not, they are unchanged
bool relaxAtScale(const Physics& physics, const Execution& execution, double scale, int sweeps,
                  const std::function<bool()>& stop, GrowingCells& cells);

/// Turns placed cells into a valid initial state: cells larger than `smallest` that overlap each other, a
/// fixed cell or the wall are halved until they do not, and the remaining overlaps are resolved by relaxation
/// at those scales. All ranks call; the result does not depend on their number.
/// @param own this rank's cells: fixed ones at scale 1, existing ones at scale 1 or less, all others at
///   `smallest`
/// @return whether the cells are valid now; false: they do not fit even at this scale, or it was stopped
bool seed(const Physics& physics, const Execution& execution, double smallest,
          const std::function<bool()>& stop, std::vector<Body>& own);

}  // namespace packmesh
