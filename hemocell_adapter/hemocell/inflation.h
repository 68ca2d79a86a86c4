// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How HemoCell inflates every surface it reads or builds.
#pragma once

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh::hemocell {

/// Distance by which HemoCell moves every vertex outwards, in lattice units: templates and vessels alike.
inline constexpr double inflation = 1e-3;

/// Moves each vertex by `distance` along the normalised unweighted mean of the unit normals of its faces. One
/// vertex after the other and in place, as HemoCell does it: later vertices see their neighbours already
/// moved.
void inflate(TriangleMesh& mesh, double distance);

}  // namespace packmesh::hemocell
