// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HemoCell's inflation of all surfaces that it reads or builds.
#pragma once

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh::hemocell {

/// Distance by which HemoCell moves every vertex of templates and vessels outwards, in lattice units.
inline constexpr double inflation = 1e-3;

/// Moves each vertex by `distance` along the normalised unweighted mean of the unit normals of its faces. As
/// in HemoCell, sequentially and in place: later vertices see their neighbours already moved.
void inflate(TriangleMesh& mesh, double distance);

}  // namespace packmesh::hemocell
