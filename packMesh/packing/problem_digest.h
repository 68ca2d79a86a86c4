// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Identification of problems.
#pragma once

#include <string>

#include "packMesh/packing/packing_problem.h"

namespace packmesh {

/// 32 hexadecimal digits that identify a problem (XXH3): species and their meshes, numbers, seed, clearances,
/// method, the lumen (extent, volume, distances at some points). Not the execution: a run may be resumed with
/// another one.
std::string digestOf(const PackingProblem& problem);

}  // namespace packmesh
