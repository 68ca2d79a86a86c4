// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Closing of flat openings of a surface, such as the ends of a vessel.
#pragma once

#include <string>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

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
