// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Steps that the program shares with packing for a running HemoCell.
#pragma once

#include <cstdint>
#include <vector>

#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/scene.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// The scene of a job, with its notices logged. All ranks call. @throws AgreedFailure
Scene builtScene(const Job& job, const Communicator& ranks);

/// The cells of a result, on all ranks.
struct Counted {
  std::vector<std::int64_t> parts;  ///< by part of the scene
  Tally tally;                      ///< by species
};

/// Counts the cells, whose species are parts of the scene before and species of the scene after. All ranks
/// call.
Counted counted(const Scene& scene, PackingResult& result, const Communicator& ranks);

/// The summary of a run, of which all cells are packed.
void logSummary(const Scene& scene, const Counted& counted, const Certificate& certificate, const Kept& kept,
                const RunTimes& times);

}  // namespace packmesh::hemocell
