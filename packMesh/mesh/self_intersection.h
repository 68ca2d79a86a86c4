// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Self-intersection test.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

using TrianglePair = std::pair<int, int>;

/// True if two triangles with area have common points other than the vertices and edges they share by index.
/// Exact.
bool meetBeyondShared(const std::vector<Vec3>& vertices, Triangle s, Triangle t);

/// Two triangles of `mesh` that have common points other than the vertices and edges they share by index;
/// empty if there are none. Exact. A triangle without area is returned as a pair with itself.
std::optional<TrianglePair> findSelfIntersection(const TriangleMesh& mesh);

}  // namespace packmesh
