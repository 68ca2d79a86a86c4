// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Whether a problem fits into memory, before it is tried.
#pragma once

#include <cstdint>

#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Memory that a process with this share of the cells takes at least [bytes], cells that have no neighbours;
/// at a hematocrit of 0.2 it is 1.5 times as much.
double leastMemory(double cells);

/// Memory that this process may still take [bytes]: what the machine, its control group and its limit of
/// address space leave, the first two shared among the ranks of the machine.
double availableMemory(const Communicator& ranks);

/// All ranks call, alone.
/// @throws InputError with figures when this rank's share of so many cells does not fit
void requireMemory(std::int64_t cells, const Communicator& ranks);

}  // namespace packmesh::hemocell
