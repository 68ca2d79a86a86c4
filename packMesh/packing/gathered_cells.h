// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The cells of all ranks on each of them, for what is not distributed.
#pragma once

#include <vector>

#include "packMesh/parallel/communicator.h"
#include "packMesh/problem/cell.h"

namespace packmesh {

/// The cells of all ranks, in the order of the ranks. All ranks call.
std::vector<PlacedCell> gatheredCells(const std::vector<PlacedCell>& own, const Communicator& ranks);

}  // namespace packmesh
