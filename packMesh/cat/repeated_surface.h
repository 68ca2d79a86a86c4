// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The surface of a periodic container, extended by its images. Internal to packMesh/cat.
#pragma once

#include <array>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Closed surface of a container together with `images[k]` images of it on either side along each periodic
/// axis k. The triangles in the planes that bound one period are openings, where images are joined.
/// @param surface closed, of one period; @param bounds of that period [µm]
/// @param period [µm], 0: not periodic
/// @throws InputError if the two ends along an axis are not flat, or do not match vertex by vertex
TriangleMesh repeatedSurface(const TriangleMesh& surface, const Box& bounds, const Vec3& period,
                             const std::array<int, 3>& images);

}  // namespace packmesh
