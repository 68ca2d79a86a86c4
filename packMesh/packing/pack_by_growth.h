// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Packing in which growth does everything, as in the thesis.
#pragma once

#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"

namespace packmesh {

/// pack() for Method::cat: cells start small (eq. 3.6) and grow to scale 1 (Algorithm 1). When they do not
/// all get there the result has those that did. Pre: validate() has passed
PackingResult packByGrowth(const PackingProblem& problem);

}  // namespace packmesh
