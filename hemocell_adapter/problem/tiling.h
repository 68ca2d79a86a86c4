// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Packings of periodic boxes that are repeated in larger ones.
#pragma once

#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// @throws InputError if the box is not periodic along an axis along which it is repeated, or if there are
///   too many cells
void requireTileable(const Problem& problem);

/// The problem of packing a larger box with cells that are there: those of `result`, whose species are the
/// problem's, with all images of a cell in succession. All ranks call; each gets all cells.
/// @param clearances that the packing has
/// @throws InputError as requireTileable()
Problem tiledProblem(const Problem& problem, const Clearances& clearances, const PackingResult& result);

}  // namespace packmesh::hemocell
