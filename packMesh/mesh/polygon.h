// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Polygons in a plane.
#pragma once

#include <array>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

using Polygon = std::vector<Eigen::Vector2d>;  ///< simple, closed, without repeating its first point

/// The closed loops formed by segments with common end points, each counter-clockwise.
/// @throws MeshError if there are none, or one lies within another
std::vector<Polygon> loopsOf(const std::vector<std::array<Eigen::Vector2d, 2>>& segments);

/// Twice the signed area, positive if counter-clockwise.
double twiceArea(const Polygon& polygon);

bool contains(const Polygon& polygon, const Eigen::Vector2d& point);

/// Triangulates a simple polygon without new points, by ear clipping (exact predicates). Pre: simple. @throws
/// MeshError if there is no ear: the polygon is clockwise or intersects itself
std::vector<Triangle> triangulated(const Polygon& polygon);

/// The closed, outward-oriented prism over a polygon in the plane perpendicular to `axis`, from `lo` to `hi`.
/// The polygon's coordinates are those of axes axis + 1 and axis + 2, cyclically. Pre: counter-clockwise, lo
/// < hi.
TriangleMesh prismOver(const Polygon& polygon, int axis, double lo, double hi);

}  // namespace packmesh
