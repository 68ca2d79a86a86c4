// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cells that are stuck are taken out and put where there is more room.
#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "packMesh/placement/accessible_space.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"
#include "packMesh/relaxation/body.h"

namespace packmesh {

/// Puts cells into the largest rooms of those that are tried: poses that do not meet the wall, drawn from the
/// seed, the cell's id and `round`, in which the gap to the nearest other cell is largest. The same on any
/// number of ranks. All ranks call.
/// @param own this rank's cells; changed where they are relocated
/// @param stuck ids of cells that are not fixed, the same on all ranks
/// @return ids of the cells that were relocated; there is no room for the others
std::set<std::int64_t> relocate(const Physics& physics, const Execution& execution, AccessibleSpaces& spaces,
                                std::int64_t round, const std::set<std::int64_t>& stuck,
                                std::vector<BodyState>& own);

}  // namespace packmesh
