// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Surfaces that touch themselves. Internal to packMesh/growth.
#pragma once

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Separates parts of a closed, outward-oriented surface that touch each other in edges or vertices by
/// duplicating vertices, so that exactly two triangles share every edge and one fan every vertex. If more
/// than two triangles share an edge, those that bound the same part of the inside are joined. Unused vertices
/// are removed.
TriangleMesh separateTouchingParts(const TriangleMesh& mesh);

}  // namespace packmesh
