// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The one public entry of the library.
#pragma once

#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"

namespace packmesh {

/// Packs the cells of `problem` into its container so that no two meshes meet and every mesh is in the lumen.
///
/// Same problem, same bytes: the result depends on the problem alone (seed included), never on time, machine
/// or processor features, unless the time limit stops it.
/// @throws InputError when the problem cannot be one (a cell that fits in no orientation, more cell volume
/// than
///   lumen volume, negative clearance, ...)
PackingResult pack(const PackingProblem& problem);

}  // namespace packmesh
