// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cells at given scales, relaxed as rigid bodies.
#pragma once

#include <functional>

#include "packMesh/growth/growing_cells.h"
#include "packMesh/relaxation/relaxation.h"

namespace packmesh {

/// The input of a relaxation with all constraints of the scene.
RelaxationInput relaxationInputOf(const GrowthScene& scene);

/// Relaxes cells, enlarged to at least `scale`, as rigid bodies for at most the given number of sweeps: the
/// contact relaxation of the default method, with all constraints of the scene. If the exact test finds the
/// result free of overlap, repaired where needed, it replaces the cells. All ranks call.
/// @return whether the cells were replaced; if not, they are unchanged
bool relaxAtScale(const GrowthScene& scene, double scale, int sweeps, const std::function<bool()>& stop,
                  GrowingCells& cells);

}  // namespace packmesh
