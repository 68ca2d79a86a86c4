// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which parts of surfaces tetrahedra do not respect. Internal to packMesh/growth.
#pragma once

#include <vector>

#include "packMesh/growth/tetgen_run.h"

namespace packmesh {

/// The triangles that are no faces of the tetrahedra: indices, ascending. Takes about as long as looking at
/// every tetrahedron once.
/// @param points how many there are
std::vector<int> missingTriangles(const std::vector<Triangle>& triangles,
                                  const std::vector<Tetrahedron>& tetrahedra, std::size_t points);

/// The triangles that are, most likely, no faces of the Delaunay tetrahedra of the points: those through
/// whose corners no empty sphere of up to about the triangle's size was found. Takes a hundredth of the time
/// that tetrahedra take.
std::vector<int> likelyMissing(const std::vector<Triangle>& triangles, const std::vector<Vec3>& points);

}  // namespace packmesh
