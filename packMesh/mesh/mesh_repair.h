// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Check and repair of closed surfaces.
#pragma once

#include <string>
#include <vector>

#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/flat_openings.h"

namespace packmesh {

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
/// are closed as well (flat_openings.h), and added here
std::vector<std::string> repairClosed(TriangleMesh& mesh, const std::string& name,
                                      std::vector<CappedOpening>* capped = nullptr,
                                      double flatness = tolerance::flatCapFraction,
                                      std::string* crossing = nullptr);

}  // namespace packmesh
