// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What Method::cat needs of packMesh/cat, besides engineFor() and hasCat(). without_cat.cpp stands in
/// for it where that is not built (CMake: PACKMESH_CAT).
#pragma once

#include <vector>

#include "packMesh/packing/packing_file.h"
#include "packMesh/problem/physics.h"

namespace packmesh::hemocell {

/// The cells of the chordal axis transform around all cells of a packing, in their order; none if TetGen
/// fails.
std::vector<NamedMesh> catCellsOf(const std::vector<PlacedCell>& all, const Physics& physics);

}  // namespace packmesh::hemocell
