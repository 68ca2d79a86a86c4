// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Distance between triangles.
#pragma once

#include "packMesh/core/vector.h"

namespace packmesh {

/// Distance between two closed triangles that do not meet [µm], in double precision (error about 1e-13 of the
/// triangles' size and distance, at any position). For triangles that meet, some number >= 0. Degenerate
/// triangles are handled correctly.
double triangleDistance(const Vec3& a0, const Vec3& a1, const Vec3& a2, const Vec3& b0, const Vec3& b1,
                        const Vec3& b2);

}  // namespace packmesh
