// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cells that stay where they are.
#pragma once

#include "packMesh/packing/packing_problem.h"

namespace packmesh {

/// Fixed cells that meet each other or the wall no packing can mend. All ranks examine all of them.
/// @throws InputError naming the first that do
void requireFixedApart(const PackingProblem& problem);

}  // namespace packmesh
