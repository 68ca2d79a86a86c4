// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Validity of a problem.
#pragma once

#include "packMesh/packing/packing_problem.h"

namespace packmesh {

/// Volume of all cells [µm³].
double cellVolume(const PackingProblem& problem);

/// @throws InputError if the problem is invalid: no container, negative counts or clearances, a cell that is
///   larger than the lumen, more cell volume than lumen volume, fixed cells that violate the clearances
void validate(const PackingProblem& problem);

}  // namespace packmesh
