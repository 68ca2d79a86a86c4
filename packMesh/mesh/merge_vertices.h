// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Merging of equal or nearly equal vertices, removal of unused ones.
#pragma once

#include <cstddef>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Keeps the first of all vertices with equal coordinates, in order of first occurrence.
/// @return for each input vertex its index among those kept
std::vector<int> mergeEqualVertices(std::vector<Vec3>& vertices);

/// The same for the vertices of a mesh. @return number of vertices removed
std::size_t mergeEqualVertices(TriangleMesh& mesh);

/// For each vertex, the first vertex connected to it by a chain of steps shorter than `distance` [µm];
/// usually itself. At most about 1000 n pairs are compared: if the vertices are so crowded that this does not
/// suffice, some steps are overlooked.
std::vector<int> firstOfNearVertices(const std::vector<Vec3>& vertices, double distance);

/// Removes the vertices that no triangle uses; keeps the order of the others. @return number of vertices
/// removed
std::size_t removeUnusedVertices(TriangleMesh& mesh);

}  // namespace packmesh
