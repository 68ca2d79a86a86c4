// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The nodes of a lattice whose flags are distributed over the ranks.
#pragma once

#include <memory>
#include <vector>

#include "hemocell_adapter/hemocell/lattice.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Fluid nodes from..to of the row (j, k) along x.
struct FluidRun {
  std::int32_t from, to, j, k;
};

/// Lattices of more nodes are distributed: this many flags are 2 MB.
constexpr std::int64_t mostNodesOnEveryRank = 1 << 24;

/// The lattice in which the runs of all ranks are fluid, and all other nodes solid. On every rank, or, if it
/// is larger than `mostOnEveryRank` nodes, in pages: each rank has a share of them and copies of those it has
/// read. All ranks call; they all release it together, too.
std::shared_ptr<const Lattice> latticeOfRuns(const std::array<int, 3>& nodes, double dx,
                                             const std::vector<FluidRun>& runs, const Communicator& ranks,
                                             std::int64_t mostOnEveryRank);

}  // namespace packmesh::hemocell
