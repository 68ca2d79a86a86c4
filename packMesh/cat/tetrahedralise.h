// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Tetrahedra by TetGen.
#pragma once

#include "packMesh/cat/tetrahedra.h"

namespace packmesh {

/// Tetrahedra with vertices on the objects and the container.
///
/// Constrained: edges and triangles that are not present in the Delaunay tetrahedra are enforced by Steiner
/// points on them; a Steiner point has the label of its surface. If periodic and with `freeSpace`, TetGen is
/// run until images of an object have the same Steiner points, so that the tetrahedra are periodic too
/// (Steiner points on the container are not); with `joining` they are, except near a few Steiner points. The
/// result does not depend on the order of the objects, apart from the numbering in it.
/// @throws MeshError, InputError see requireValid()
/// @throws InputError if the program that runs TetGen is missing, see tetgenProgram()
/// @throws TetrahedraError if TetGen fails in every mode
Tetrahedra tetrahedralise(const TetrahedraInput& input);

}  // namespace packmesh
