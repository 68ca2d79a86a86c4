// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Is a problem one that can be posed.
#pragma once

#include "packMesh/packing/packing_problem.h"

namespace packmesh {

/// Volume of all cells [µm³].
double cellVolume(const PackingProblem& problem);

/// @throws InputError when the problem cannot be one: no container, negative counts or clearances, a cell
///   that is larger than the lumen, more cell volume than lumen volume, fixed cells that violate the
///   clearances
void validate(const PackingProblem& problem);

}  // namespace packmesh
