// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The search for the densest packing of fewer cells than were asked for.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/packing/run_control.h"

namespace packmesh {

/// What the search came to.
struct Densest {
  std::optional<PackingResult> packing;  ///< the densest certified one; nothing: none in time
  bool whole = false;                    ///< all cells could be packed after all
  bool ended = false;                    ///< by itself, not by time
  std::int64_t sweeps = 0;               ///< of all trials
};

/// Goes on with an attempt at all cells, up to so many sweeps of it. @return whether they are packed now
using WholeAttempt = std::function<bool(std::int64_t sweeps)>;

/// Looks for the densest packing of fewer cells than the problem has (Method::relaxation). Every trial packs
/// cells up to a hematocrit afresh, at most the first parts of relax(); species keep their shares, fixed
/// cells stay. It bisects coarsely with the first part, then climbs and bisects more finely with two; while
/// there is a time limit, with one more each time it gets no further. Where it comes to as many cells as were
/// asked for, `whole` goes on as far as a trial would.
///
/// The trials depend on what is packed into what, not on how many cells were asked for: who asks for more
/// gets no less, but for part of a rung. Without a time limit, the result depends on the problem alone. All
/// ranks call.
Densest findDensest(const PackingProblem& problem, RunControl& control, const WholeAttempt& whole);

}  // namespace packmesh
