// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The cells of a problem where they start.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/run_control.h"

namespace packmesh {

/// Whether a cell of a species starts where the problem says, not at random. Cells are numbered within it.
bool startsAtGivenPose(const Species& species, std::int64_t cell);

/// The cells of this rank's share at full size: where the problem says, or at random. All ranks call.
/// @return nothing when there was no time for it
std::optional<std::vector<Body>> placedCells(const PackingProblem& problem, std::uint64_t seed,
                                             const IdShares& shares, RunControl& control);

}  // namespace packmesh
