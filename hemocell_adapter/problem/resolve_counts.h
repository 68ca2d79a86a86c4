// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Numbers of the cells of a problem, and whether so many can be there.
#pragma once

#include <cstdint>
#include <vector>

#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// Mean volumes of the cells of each species before it is known which of them are placed: those of the cells
/// that exist already. Pre: the species have their shapes
void guessVolumes(Problem& problem);

/// The number of cells of each species by the request and CellSpecies::countedVolume. Pre: the problem has
/// its lumen with regions
/// @throws InputError see countCells()
std::vector<std::int64_t> numbersOfCells(const Problem& problem);

/// Examines whether so many cells can be there, and adds notices to the problem. Pre: it has its lumen, its
/// species with shapes and acceptance, and their numbers
/// @throws InputError if cells fit nowhere in the lumen, if HemoCell would delete every one of a kind, or if
///   they fill more of the lumen than there is, or than any known packing does
void examineNumbers(Problem& problem);

}  // namespace packmesh::hemocell
