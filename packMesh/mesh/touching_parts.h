// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Surfaces that touch themselves.
#pragma once

#include <cstddef>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Separates parts of a closed, outward-oriented surface that touch each other in edges or vertices by
/// duplicating vertices, so that exactly two triangles share every edge and one fan every vertex. If more
/// than two triangles share an edge, those that bound the same part of the inside are joined. Unused vertices
/// are removed.
TriangleMesh separateTouchingParts(const TriangleMesh& mesh);

/// Separates such parts and moves them apart: every vertex that was duplicated moves by
/// tolerance::touchingFraction of the distance to the mean of its neighbours. Whether the surface intersects
/// itself afterwards is not tested. Pre: every edge has as many triangles in one direction as in the other
/// @return number of vertices in which parts touched; if 0, the mesh is unchanged
std::size_t moveTouchingPartsApart(TriangleMesh& mesh);

}  // namespace packmesh
