// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The search for the densest packing of fewer cells than were asked for.
#pragma once

#include <cstdint>
#include <optional>

#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/packing/run_control.h"

namespace packmesh {

/// What the search came to.
struct Densest {
  std::optional<PackingResult> packing;  ///< the densest certified one; nothing: none in time
  bool ended = false;                    ///< by itself, not by time
  std::int64_t sweeps = 0;               ///< of all trials
};

/// Looks for the densest packing of fewer cells than the problem has (Method::relaxation), by bisection over
/// the volume fraction of all cells: every trial packs cells afresh, at most the first parts of relax();
/// species keep their shares, fixed cells stay. Then it climbs from the densest one found in small steps,
/// with trials of one more part; while there is a time limit, with one more each time it gets no further.
///
/// The trials depend on what is packed into what, not on how many cells were asked for: who asks for more
/// gets no less. Without a time limit, the result depends on the problem alone. All ranks call.
Densest findDensest(const PackingProblem& problem, RunControl& control);

}  // namespace packmesh
