// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Tetrahedra by TetGen.
#pragma once

#include "packMesh/growth/tetrahedra.h"

namespace packmesh {

/// Tetrahedra with vertices on the objects and the container.
///
/// Constrained: edges and triangles that are not there by themselves are made so by Steiner points on them; a
/// Steiner point has the label of its surface. Periodic and with `freeSpace`, TetGen is run until images of
/// an object have the same Steiner points, so that tetrahedra, too, are periodic (Steiner points on the
/// container are not); with `joining` they are so but for where a few Steiner points lie. The result does not
/// depend on the order of the objects, apart from the numbers in it.
/// @throws MeshError, InputError see requireValid()
/// @throws TetrahedraError when TetGen gives up in every way it can be called; it names the object or the two
///   objects that TetGen fails on
Tetrahedra tetrahedralise(const TetrahedraInput& input);

}  // namespace packmesh
