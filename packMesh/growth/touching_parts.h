// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Surfaces that touch themselves. Internal to packMesh/growth.
#pragma once

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Gives parts of a closed, outward-oriented surface that touch each other in edges or vertices vertices of
/// their own, so that just two triangles meet in every edge and one fan of them in every vertex. Where more
/// than two meet in an edge, those are joined that bound the same part of the inside. Vertices that are in no
/// triangle are dropped.
TriangleMesh separateTouchingParts(const TriangleMesh& mesh);

}  // namespace packmesh
