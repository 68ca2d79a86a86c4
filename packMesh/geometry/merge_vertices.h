// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Vertices that are one point.
#pragma once

#include <vector>

#include "packMesh/geometry/vector.h"

namespace packmesh {

/// Keeps the first of all vertices with equal coordinates, in the order of their first appearance.
/// @return for each vertex given its number among those kept
std::vector<int> mergeEqualVertices(std::vector<Vec3>& vertices);

/// For each vertex the first vertex (itself, mostly) that a chain of steps shorter than `distance` [µm]
/// connects it with. Cost: n log n for a distance much smaller than that of most vertices.
std::vector<int> firstOfNearVertices(const std::vector<Vec3>& vertices, double distance);

}  // namespace packmesh
