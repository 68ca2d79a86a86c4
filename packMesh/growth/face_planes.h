// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The planes of CAT faces.
#pragma once

#include <vector>

#include "packMesh/growth/chordal_split.h"
#include "packMesh/growth/plane_constraint.h"

namespace packmesh {

/// For every object, the planes of its CAT faces, each for the vertex that it belongs to (v, q, n of the
/// thesis).
/// @param objects as they were given to tetrahedralise()
/// @param minimumCosine faces are left out whose normal has nothing to do with the gap, that is, where the
/// largest
///   cosine of the angle between the normal and an edge of the tetrahedron from one side to the other is
///   smaller: slivers have such faces, and they lock cells (0.3 does well); 0: all faces, as in the thesis
/// @param reach per object, how far any of its points may move [µm]: planes further away are left out; empty:
///   none are
PlaneConstraints planesOfFaces(const Tetrahedra& tetrahedra, const ChordalFaces& faces,
                               const std::vector<PlacedMesh>& objects, double minimumCosine,
                               const std::vector<double>& reach = {});

}  // namespace packmesh
