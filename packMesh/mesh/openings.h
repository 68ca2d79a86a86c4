// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Polygons in a plane, and the flat openings of a surface that they close, such as the ends of a
/// vessel.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

using Polygon = std::vector<Vec2>;  ///< simple, closed, without repeating its first point

/// The closed loops formed by segments with common end points, each counter-clockwise.
/// @throws MeshError if there are none, or one lies within another
std::vector<Polygon> loopsOf(const std::vector<std::array<Vec2, 2>>& segments);

/// Twice the signed area, positive if counter-clockwise.
double twiceArea(const Polygon& polygon);

bool contains(const Polygon& polygon, const Vec2& point);

/// Triangulates a simple polygon without new points, by ear clipping (exact predicates). Pre: simple. @throws
/// MeshError if there is no ear: the polygon is clockwise or intersects itself
std::vector<Triangle> triangulated(const Polygon& polygon);

/// The closed, outward-oriented prism over a polygon in the plane perpendicular to `axis`, from `lo` to `hi`.
/// The polygon's coordinates are those of axes axis + 1 and axis + 2, cyclically. Pre: counter-clockwise, lo
/// < hi.
TriangleMesh prismOver(const Polygon& polygon, int axis, double lo, double hi);

/// A flat opening that was closed by triangles, in the frame and unit of the mesh.
struct CappedOpening {
  Vec3 center = Vec3::Zero();
  double area = 0.0;
  std::size_t edges = 0;
  double deviation = 0.0;  ///< largest distance of its vertices from their plane; 0: flat, up to rounding
};

/// Closes all openings of `mesh` if each is one closed outline in a plane, up to `flatness` (a fraction of
/// the mesh's diagonal); else leaves it unchanged. Outlines that are not star-shaped around their centre are
/// closed without a new vertex. Pre: no edge has more than two triangles
/// @param sides sortedSides(mesh)
/// @param capped receives the openings
/// @return why an opening cannot be closed, and where it is; empty: all are closed
std::string capFlatOpenings(TriangleMesh& mesh, const std::vector<TriangleSide>& sides, double flatness,
                            std::vector<CappedOpening>& capped);

}  // namespace packmesh
