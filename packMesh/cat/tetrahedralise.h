// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Tetrahedra between objects, by runs of TetGen.
#pragma once

#include <vector>

#include "packMesh/cat/tetgen_data.h"
#include "packMesh/cat/tetrahedra.h"

namespace packmesh {

/// The triangles that are not faces of the tetrahedra: indices, ascending. Takes about as long as one pass
/// over the tetrahedra.
/// @param points number of points
std::vector<int> missingTriangles(const std::vector<Triangle>& triangles,
                                  const std::vector<Tetrahedron>& tetrahedra, std::size_t points);

/// The triangles that are, most likely, not faces of the Delaunay tetrahedra of the points: those for which
/// no empty sphere of up to about the triangle's size through their corners was found. Takes a hundredth of
/// the time of a tetrahedralisation.
std::vector<int> likelyMissing(const std::vector<Triangle>& triangles, const std::vector<Vec3>& points);

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
