// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Does a surface meet itself?
#pragma once

#include <optional>
#include <utility>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

using TrianglePair = std::pair<int, int>;

/// Two triangles of `mesh` that meet elsewhere than in the vertices and edges they share by index, or
/// nothing. Exact. A triangle without area is returned as a pair with itself.
std::optional<TrianglePair> findSelfIntersection(const TriangleMesh& mesh);

}  // namespace packmesh
