// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file CAT cells (thesis 3.1.2.2) as closed surfaces: for looking at, measuring and testing. Growth needs
/// only the planes of their faces (chordal_split.h).
#pragma once

#include <vector>

#include "packMesh/growth/chordal_split.h"

namespace packmesh {

/// The space of every object: its own and the segments of tetrahedra around it that are its.
struct CatCells {
  /// Per object, where the object was given: closed, outward-oriented two-manifold surfaces [µm]. Cells share
  /// faces, with the same vertices and triangles, turned round. With faces at the wall, parts of a cell's
  /// surface may touch in vertices or edges on the container; they have vertices of their own there.
  std::vector<TriangleMesh> cells;
  /// What is left to the container: with faces in mid-gap, the layer along its wall, else nothing. Only
  /// without periodic images.
  TriangleMesh wallLayer;
};

/// The CAT cells of all objects. With faces at the wall, they fill the container: tetrahedra that have all
/// corners on the container go to the cell they have the largest face in common with. Pre: the tetrahedra
/// fill the free space (TetrahedraKept::freeSpace, constrained), within a container, along every
///   axis that is not periodic
CatCells catCells(const Tetrahedra& tetrahedra, WallFaces wall);

}  // namespace packmesh
