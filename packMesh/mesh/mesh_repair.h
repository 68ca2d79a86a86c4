// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Is a mesh a closed surface, and what can be mended safely.
#pragma once

#include <string>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Makes `mesh` a closed, outward-oriented, two-manifold surface or says why it cannot be one.
///
/// Mended: duplicate vertices (merged), unused vertices and collapsed triangles (removed), cracks no wider
/// than rounding (closed), triangles oriented against their neighbours, triangles with three collinear
/// corners (see removeFlatTriangles; nearly collinear ones where the surface meets itself), surfaces inside
/// out (flipped). Everything else is refused.
/// @return one line for each kind of repair made, for a warning; empty when the mesh was sound
/// @throws MeshError naming `name` and the place: no triangles, open edges (how many, where the first),
///   non-manifold edges, non-finite coordinates, a vertex far away from all others, zero volume,
///   self-intersection (where)
std::vector<std::string> repairClosed(TriangleMesh& mesh, const std::string& name);

}  // namespace packmesh
