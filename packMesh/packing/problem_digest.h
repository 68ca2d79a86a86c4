// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Whether two problems are one.
#pragma once

#include <string>

#include "packMesh/packing/packing_problem.h"

namespace packmesh {

/// 32 hexadecimal digits that tell problems apart (XXH3): species and their meshes, numbers, seed,
/// clearances, method, the lumen (extent, volume, distances at some points). Limits, ranks and callbacks are
/// no part of it: a run may go on with others.
std::string digestOf(const PackingProblem& problem);

}  // namespace packmesh
