// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cells at given scales, relaxed as rigid bodies.
#pragma once

#include <functional>

#include "packMesh/cat/growing_cells.h"
#include "packMesh/relaxation/relaxation.h"

namespace packmesh {

/// Relaxes cells, enlarged to at least `scale`, as rigid bodies for at most the given number of sweeps: the
/// contact relaxation of the default method, with all constraints. If the exact test finds the
/// result free of overlap, repaired where needed, it replaces the cells. All ranks call.
/// @return whether the cells were replaced; if not, they are unchanged
bool relaxAtScale(const Physics& physics, const Execution& execution, double scale, int sweeps,
                  const std::function<bool()>& stop, GrowingCells& cells);

}  // namespace packmesh
