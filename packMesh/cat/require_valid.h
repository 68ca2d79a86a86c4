// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Validity of input for TetGen.
#pragma once

#include "packMesh/cat/tetrahedra.h"

namespace packmesh {

/// Refuses input that TetGen cannot process: TetGen 1.5 crashes on surfaces that intersect.
/// @throws MeshError naming the object whose mesh is open, intersects itself, is flat ... (see repairClosed)
/// @throws InputError naming the objects that overlap or contain each other (exact, periodic images
///   included), or the one that is not inside the container
void requireValid(const TetrahedraInput& input);

}  // namespace packmesh
