// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Polygons in a plane.
#pragma once

#include <array>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

using Polygon = std::vector<Eigen::Vector2d>;  ///< simple, closed, without repeating its first point

/// The closed loops that segments with common end points form, each counter-clockwise.
/// @throws MeshError when they form none, or one lies within another
std::vector<Polygon> loopsOf(const std::vector<std::array<Eigen::Vector2d, 2>>& segments);

/// Twice the signed area, positive when counter-clockwise.
double twiceArea(const Polygon& polygon);

bool contains(const Polygon& polygon, const Eigen::Vector2d& point);

/// Triangles of a simple polygon without new points, by cutting off ears (exact predicates).
/// Pre: simple. @throws MeshError when there is no ear: the polygon runs clockwise
std::vector<Triangle> triangulated(const Polygon& polygon);

/// The closed, outward-oriented prism over a polygon in the plane across `axis` (its points have the
/// coordinates axis + 1 and axis + 2, cyclically) from `lo` to `hi`. Pre: counter-clockwise, lo < hi.
TriangleMesh prismOver(const Polygon& polygon, int axis, double lo, double hi);

}  // namespace packmesh
