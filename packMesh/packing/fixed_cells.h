// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Validity of fixed cells.
#pragma once

#include "packMesh/parallel/threads.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

/// Refuses fixed cells that overlap each other or the wall, since no packing is possible then. All ranks
/// examine all of them.
/// @throws InputError naming the first that do
void requireFixedApart(const Physics& physics, const Threads& threads);

}  // namespace packmesh
