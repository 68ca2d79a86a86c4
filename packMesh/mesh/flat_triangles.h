// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Removal of triangles without area from a closed surface.
#pragma once

#include <cstddef>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Removes triangles whose three distinct corners are collinear from a closed surface: the triangle across
/// the longest side is split at the middle corner, as if that side were flipped. All vertices are kept, and
/// the surface moves at most by the height of these triangles, which is 0 by default. Pre: closed, neighbours
/// consistently oriented.
/// @param flatness triangles no higher than this fraction of their longest side are removed; 0: exactly
/// collinear
/// @return number of triangles removed; those that cannot be removed are kept
std::size_t removeFlatTriangles(TriangleMesh& mesh, double flatness = 0.0);

}  // namespace packmesh
