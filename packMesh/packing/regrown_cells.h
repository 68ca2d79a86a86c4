// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Growth as the end of relaxation.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "packMesh/growth/regrowth.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/relaxation/relaxation.h"

namespace packmesh {

/// A cell that growth has moved.
struct MovedCell {
  std::int64_t id;
  Pose before, after;
};

/// Where the cells that meet, and those around them, would be after shrinking and growing again (see
/// regrow()); the relaxation is left as it is. Empty when growth does not get them to full size. All ranks
/// call, and all grow all such cells: they are few.
/// @param faults of all ranks, by ids
std::vector<MovedCell> regrownCells(const PackingProblem& problem, const Relaxation& relaxation,
                                    const Certificate& faults, const std::function<bool()>& stop,
                                    RegrowthSums& sums);

}  // namespace packmesh
