// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The main public function of the library.
#pragma once

#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"

namespace packmesh {

/// Volume of all cells [µm³].
double cellVolume(const PackingProblem& problem);

/// @throws InputError if the problem is invalid: no container, negative counts or clearances, a cell that is
///   larger than the lumen, more cell volume than lumen volume, fixed cells that violate the clearances
void validate(const PackingProblem& problem);

/// Packs the cells of `problem` into its container so that no two meshes overlap and every mesh is inside the
/// lumen.
///
/// The result is reproducible to the byte: it depends on the problem alone (seed included), never on timing,
/// machine or processor features, unless the time limit stops it.
/// @throws InputError if the problem is invalid (a cell larger than the lumen, more cell volume than
///   lumen volume, negative clearance, ...)
PackingResult pack(const PackingProblem& problem);

}  // namespace packmesh
