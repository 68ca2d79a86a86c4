// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Numbers of cells from hematocrits and ratios.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hemocell_adapter/problem/cell_species.h"

namespace packmesh::hemocell {

/// Determines the number of cells of each kind.
///
/// A ratio is the number of cells per red cell, where the red cells of all species count. For a species of
/// red cells it is therefore the share of these cells among all red cells (a parasitaemia, for example). With
/// a hematocrit, the species of red cells without count and ratio gets the number for which the volume of all
/// red cells is nearest to hematocrit · lumenVolume.
/// @param species with countedVolume
/// @throws InputError if nothing is to be packed, if the hematocrit would determine several species, if the
///   red cells with counts exceed it, or if the ratios of red species add up to 1 or more
std::vector<std::int64_t> countCells(const std::vector<CellSpecies>& species,
                                     std::optional<double> hematocrit, double lumenVolume);

}  // namespace packmesh::hemocell
