// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file CAT cells (thesis 3.1.2.2) as closed surfaces, for visualisation, measurement and tests. Growth only
/// needs the planes of their faces (chordal_split.h).
#pragma once

#include <vector>

#include "packMesh/cat/chordal_split.h"

namespace packmesh {

/// The CAT cell of every object: the object and the adjacent segments of tetrahedra that belong to it.
struct CatCells {
  /// Per object, at its given position: closed, outward-oriented two-manifold surfaces [µm]. Adjacent cells
  /// share faces with the same vertices and triangles, in opposite orientation. With faces at the wall, parts
  /// of a cell's surface may touch in vertices or edges on the container; these have separate vertices.
  std::vector<TriangleMesh> cells;
  /// The part that belongs to the container: with faces in mid-gap, the layer along its wall, otherwise
  /// empty. Only without periodic images.
  TriangleMesh wallLayer;
};

/// The CAT cells of all objects. With faces at the wall, they fill the container: tetrahedra with all corners
/// on the container are assigned to the cell with which they share the largest face. Pre: the tetrahedra fill
/// the free space (TetrahedraKept::freeSpace, constrained), within a container, along every axis that is not
/// periodic.
CatCells catCells(const Tetrahedra& tetrahedra, WallFaces wall);

}  // namespace packmesh
