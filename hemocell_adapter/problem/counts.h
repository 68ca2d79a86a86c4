// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How many cells a hematocrit is.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hemocell_adapter/problem/cell_species.h"

namespace packmesh::hemocell {

/// The number of cells of each kind.
///
/// A ratio is the number of cells per red cell, where the red cells of all species count. Of a red species it
/// is therefore the share of these cells among all red cells (a parasitaemia, say). With a hematocrit, the
/// red species without count and ratio gets the number that brings the volume of all red cells nearest to
/// hematocrit · lumenVolume.
/// @param species with countedVolume
/// @throws InputError when nothing is to be packed, several species wait for the hematocrit, the red cells
/// with
///   counts exceed it, or the ratios of red species add up to 1 or more
std::vector<std::int64_t> countCells(const std::vector<CellSpecies>& species,
                                     std::optional<double> hematocrit, double lumenVolume);

}  // namespace packmesh::hemocell
