// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Vertices that are one point, and vertices that are none.
#pragma once

#include <cstddef>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Keeps the first of all vertices with equal coordinates, in the order of their first appearance.
/// @return for each vertex given its number among those kept
std::vector<int> mergeEqualVertices(std::vector<Vec3>& vertices);

/// For each vertex the first vertex (itself, mostly) that a chain of steps shorter than `distance` [µm]
/// connects it with. Cost: n log n for a distance much smaller than that of most vertices.
std::vector<int> firstOfNearVertices(const std::vector<Vec3>& vertices, double distance);

/// Drops the vertices that no triangle uses, keeping the order of the others. @return how many were dropped
std::size_t removeUnusedVertices(TriangleMesh& mesh);

}  // namespace packmesh
