// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Where cells are put: at the beginning, and when they are stuck and there is more room elsewhere.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "packMesh/packing/engine.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/placement/accessible_space.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"
#include "packMesh/relaxation/body.h"

namespace packmesh {

/// The cells of this rank's share at full size: at their given initial poses, or at random. All ranks call.
/// @return nothing if there was no time for it
std::optional<std::vector<Body>> placedCells(const Physics& physics, Execution execution,
                                             const IdShares& shares, RunControl& control);

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
