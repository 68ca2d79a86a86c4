// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The lattice of a running HemoCell, of which each rank knows a part.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "hemocell_adapter/hemocell/lattice.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Fluid nodes from..to of the row (j, k) along x.
struct FluidRun {
  std::int32_t from, to, j, k;
};

/// The ranks of a computer share the flags of lattices of more nodes: this many flags are 2 MB.
constexpr std::int64_t mostNodesOnEveryRank = 1 << 24;

/// The lattice in which the runs of all ranks are fluid, and all other nodes solid. On every rank, or, if it
/// is larger than `mostOnEveryRank` nodes, once on every computer. All ranks call; they all release it
/// together, too.
/// @param ranksPerNode at most this many ranks share its flags; for tests
std::shared_ptr<const Lattice> latticeOfRuns(const std::array<int, 3>& nodes, double dx,
                                             const std::vector<FluidRun>& runs, const Communicator& ranks,
                                             std::int64_t mostOnEveryRank,
                                             int ranksPerNode = std::numeric_limits<int>::max());

}  // namespace packmesh::hemocell
