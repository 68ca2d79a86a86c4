// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Exact intersection tests of closed triangles, segments and points, including all degenerate cases,
/// and the distance of triangles.
#pragma once

#include "packMesh/core/vector.h"

namespace packmesh {

/// True if two closed triangles have a common point, exactly. A single shared point counts; triangles can be
/// coplanar or degenerate (a segment or a point).
bool trianglesMeet(const Vec3& a0, const Vec3& a1, const Vec3& a2, const Vec3& b0, const Vec3& b1,
                   const Vec3& b2);

/// True if the closed segment pq and the closed triangle abc have a common point, exactly. Both can be
/// degenerate.
bool segmentMeetsTriangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c);

/// True if the closed segment pq crosses the triangle abc in one point interior to both, exactly.
bool segmentCrossesTriangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c);

/// Distance between two closed triangles that do not meet [µm], in double precision (error about 1e-13 of the
/// triangles' size and distance, at any position). For triangles that meet, some number >= 0. Degenerate
/// triangles are handled correctly.
double triangleDistance(const Vec3& a0, const Vec3& a1, const Vec3& a2, const Vec3& b0, const Vec3& b1,
                        const Vec3& b2);

}  // namespace packmesh
