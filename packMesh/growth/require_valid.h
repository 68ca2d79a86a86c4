// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What TetGen can be given.
#pragma once

#include "packMesh/growth/tetrahedra.h"

namespace packmesh {

/// Whether TetGen can be given this: TetGen 1.5 dies of surfaces that meet.
/// @throws MeshError naming the object whose mesh is open, meets itself, is flat ... (see repairClosed)
/// @throws InputError naming the objects that meet or contain each other (exact, periodic images included),
/// or
///   the one that is not inside the container
void requireValid(const TetrahedraInput& input);

}  // namespace packmesh
