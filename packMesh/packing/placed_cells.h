// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Initial cells of a problem.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/run_control.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

/// The cells of this rank's share at full size: at their given initial poses, or at random. All ranks call.
/// @return nothing if there was no time for it
std::optional<std::vector<Body>> placedCells(const Physics& physics, Execution execution,
                                             const IdShares& shares, RunControl& control);

}  // namespace packmesh
