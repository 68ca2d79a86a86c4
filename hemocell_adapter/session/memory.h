// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Whether a problem fits into memory, tested in advance.
#pragma once

#include <cstdint>

#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Lower bound of the memory of a process with this share of the cells [bytes], for cells without neighbours;
/// at a hematocrit of 0.2 it is 1.5 times as much.
double leastMemory(double cells);

/// Memory available to this process [bytes]: within the limits of the machine, its control group and its
/// address space, the first two shared among the ranks of the machine.
double availableMemory(const Communicator& ranks);

/// All ranks call, alone.
/// @throws InputError with figures when this rank's share of so many cells does not fit
void requireMemory(std::int64_t cells, const Communicator& ranks);

}  // namespace packmesh::hemocell
