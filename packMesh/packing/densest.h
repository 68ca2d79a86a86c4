// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The search for the densest packing of fewer cells than requested.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "packMesh/packing/engine.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"

namespace packmesh {

/// Result of the search.
struct Densest {
  std::optional<PackingResult> packing;  ///< the densest certified one; empty: none was found in time
  bool whole = false;                    ///< all cells could be packed after all
  bool ended = false;                    ///< completed, not stopped by the time limit
  std::int64_t sweeps = 0;               ///< of all trials
};

/// Continues the attempt to pack all cells, up to this many sweeps of it. @return whether they are packed now
using WholeAttempt = std::function<bool(std::int64_t sweeps)>;

/// Searches for the densest packing of fewer cells than the problem has. Every trial packs cells up to a
/// hematocrit from scratch, in at most as many sweeps (or iterations of the engine) as the first parts of
/// relax() have, with Engine::forTrials(); the ratios of the species are kept, and so are fixed cells. The
/// search bisects coarsely with the first part, then increases the fraction step by step and bisects more
/// finely with two; if there is a time limit or there are few cells, with one more part each time it makes no
/// progress. When it arrives at the requested number of cells, `whole` continues for as many sweeps as a
/// trial would.
///
/// The trials depend on the species and the lumen, not on the requested number of cells: a larger request
/// does not yield fewer cells, except for rounding to multiples of `rung`. Where cells are relocated and none
/// is fixed or deformed, they have as many cells as they would for a larger request, so that all cells are
/// packed if a larger request with the same seed yields as many. Without a time limit, the result depends on
/// the problem alone. All ranks call.
Densest findDensest(const PackingProblem& problem, RunControl& control, const WholeAttempt& whole);

}  // namespace packmesh
