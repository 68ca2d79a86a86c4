// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Triangles without area in a closed surface.
#pragma once

#include <cstddef>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Takes triangles whose three distinct corners are collinear out of a closed surface: the triangle beyond
/// the longest side is split at the corner in the middle, as if that side were flipped. All vertices stay,
/// and the surface moves by no more than those triangles are high: not at all, by default. Pre: closed,
/// neighbours agree in their orientation.
/// @param flatness triangles count that are no higher than this fraction of their longest side; 0: exactly
///   collinear
/// @return how many were taken out; those that cannot be stay
std::size_t removeFlatTriangles(TriangleMesh& mesh, double flatness = 0.0);

}  // namespace packmesh
