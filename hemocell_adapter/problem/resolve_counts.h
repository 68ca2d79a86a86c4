// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Numbers of the cells of a problem, and whether so many can be there.
#pragma once

#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// Determines the number of cells of each species from the request, and adds notices to the problem. Pre: it
/// has its lumen with regions, and its species with shapes and acceptance
/// @throws InputError see countCells(); if cells fit nowhere in the lumen, if HemoCell would delete every one
///   of a kind, or if they fill more of the lumen than there is, or than any known packing does
void resolveCounts(Problem& problem);

}  // namespace packmesh::hemocell
