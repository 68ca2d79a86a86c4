// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The planes of CAT faces.
#pragma once

#include <vector>

#include "packMesh/cat/cell_planes.h"
#include "packMesh/cat/chordal_split.h"

namespace packmesh {

/// For every object, the planes of its CAT faces, each with the vertex that it constrains (v, q, n of the
/// thesis).
/// @param objects as passed to tetrahedralise()
/// @param minimumCosine excludes faces whose normal is unrelated to the gap: those for which the largest
///   cosine of the angle between the normal and an edge of the tetrahedron that crosses the face is smaller
///   than this. Slivers have such faces, and they lock cells (0.3 is a good value); 0: all faces, as in the
///   thesis
/// @param reach per object, upper bound of the displacement of any of its points [µm]: planes further away
///   are left out; empty: none are
PlaneConstraints planesOfFaces(const Tetrahedra& tetrahedra, const ChordalFaces& faces,
                               const std::vector<PlacedMesh>& objects, double minimumCosine,
                               const std::vector<double>& reach = {});

}  // namespace packmesh
