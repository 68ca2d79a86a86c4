// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Triangles of surfaces that tetrahedra do not contain as faces. Internal to packMesh/cat.
#pragma once

#include <vector>

#include "packMesh/cat/tetgen_data.h"

namespace packmesh {

/// The triangles that are not faces of the tetrahedra: indices, ascending. Takes about as long as one pass
/// over the tetrahedra.
/// @param points number of points
std::vector<int> missingTriangles(const std::vector<Triangle>& triangles,
                                  const std::vector<Tetrahedron>& tetrahedra, std::size_t points);

/// The triangles that are, most likely, not faces of the Delaunay tetrahedra of the points: those for which
/// no empty sphere of up to about the triangle's size through their corners was found. Takes a hundredth of
/// the time of a tetrahedralisation.
std::vector<int> likelyMissing(const std::vector<Triangle>& triangles, const std::vector<Vec3>& points);

}  // namespace packmesh
