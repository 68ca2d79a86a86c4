// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Triangles with the same corners.
#pragma once

#include <cstddef>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Of triangles with the same three corners, those of opposite orientation cancel each other (a fin has no
/// thickness), and of those left one is kept. If that would open edges, one of each set is kept instead: a
/// cap that is there twice.
/// @return number of triangles removed; if 0, the mesh is unchanged
std::size_t removeCoincident(TriangleMesh& mesh);

}  // namespace packmesh
