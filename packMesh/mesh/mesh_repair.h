// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Check and repair of closed surfaces: triangles with the same corners or without area, parts that
/// touch.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/openings.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Of triangles with the same three corners, those of opposite orientation cancel each other (a fin has no
/// thickness), and of those left one is kept. If that would open edges, one of each set is kept instead: a
/// cap that is there twice.
/// @return number of triangles removed; if 0, the mesh is unchanged
std::size_t removeCoincident(TriangleMesh& mesh);

/// Removes triangles whose three distinct corners are collinear from a closed surface: the triangle across
/// the longest side is split at the middle corner, as if that side were flipped. All vertices are kept, and
/// the surface moves at most by the height of these triangles, which is 0 by default. Pre: closed, neighbours
/// consistently oriented.
/// @param flatness triangles no higher than this fraction of their longest side are removed; 0: exactly
/// collinear
/// @return number of triangles removed; those that cannot be removed are kept
std::size_t removeFlatTriangles(TriangleMesh& mesh, double flatness = 0.0);

/// Separates parts of a closed, outward-oriented surface that touch each other in edges or vertices by
/// duplicating vertices, so that exactly two triangles share every edge and one fan every vertex. If more
/// than two triangles share an edge, those that bound the same part of the inside are joined. Unused vertices
/// are removed.
TriangleMesh separateTouchingParts(const TriangleMesh& mesh);

/// Separates such parts and moves them apart: every vertex that was duplicated moves by
/// tolerance::touchingFraction of the distance to the mean of its neighbours. Whether the surface intersects
/// itself afterwards is not tested. Pre: every edge has as many triangles in one direction as in the other
/// @return number of vertices in which parts touched; if 0, the mesh is unchanged
std::size_t moveTouchingPartsApart(TriangleMesh& mesh);

/// Makes `mesh` a closed, outward-oriented, two-manifold surface, or throws if that is not possible.
///
/// Repaired: duplicate vertices (merged), unused vertices and collapsed triangles (removed), triangles that
/// coincide (see removeCoincident), vertices so near each other that they pinch the surface (merged), cracks
/// no wider than rounding errors (closed), inconsistently oriented triangles, triangles with three collinear
/// corners (see removeFlatTriangles; nearly collinear ones where the surface intersects itself), inverted
/// surfaces (flipped), parts that touch in vertices or edges (moved apart, see moveTouchingPartsApart).
/// Everything else is rejected.
/// @return one line per kind of repair, for a warning; empty if the mesh was valid
/// @throws MeshError with `name` and the position: no triangles, open edges (number and first one),
/// edges with an odd number of triangles, non-finite coordinates, a vertex far from all others, zero volume,
/// self-intersection
/// @param crossing if not null, a surface that intersects itself is accepted, and where it does is told here
/// @param capped if not null, openings that are flat, up to `flatness` (a fraction of the mesh's diagonal),
/// are closed as well (openings.h), and added here
std::vector<std::string> repairClosed(TriangleMesh& mesh, const std::string& name,
                                      std::vector<CappedOpening>* capped = nullptr,
                                      double flatness = tolerance::flatCapFraction,
                                      std::string* crossing = nullptr);

}  // namespace packmesh
