// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Numbers of cells from hematocrits and ratios, and whether so many can be there.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// Determines the number of cells of each kind.
///
/// A ratio is the number of cells per red cell, where the red cells of all species count. For a species of
/// red cells it is therefore the share of these cells among all red cells (a parasitaemia, for example). With
/// a hematocrit, the species of red cells without count and ratio gets the number for which the volume of all
/// red cells is nearest to hematocrit · lumenVolume.
/// Cells of regions are added to these numbers; red ones are part of the hematocrit.
/// @param species with countedVolume
/// @throws InputError if nothing is to be packed, if the hematocrit would determine several species, if the
///   red cells with counts exceed it, or if the ratios of red species add up to 1 or more
std::vector<std::int64_t> numbersOfCells(const std::vector<CellSpecies>& species,
                                         std::optional<double> hematocrit, double lumenVolume);

/// The same for the lumen of a scene, with the volume that its hematocrit refers to.
/// @param hematocrit of the lumen, where no region has its own
std::vector<std::int64_t> numbersOfCells(const Scene& scene, std::optional<double> hematocrit,
                                         const std::vector<LumenRegion>& regions);

/// Mean volumes of the cells of each species [µm³]; empty where there are none.
using MeanVolumes = std::vector<std::optional<double>>;

/// Of the cells that exist already, before it is known which of them are placed.
MeanVolumes averagePresent(const Scene& scene);
/// Of those that are placed. Pre: the species have their numbers
MeanVolumes averagePlaced(const Scene& scene, const std::vector<Part>& parts);

/// The species with other mean volumes, which count in the hematocrit unless a volume of red cells is stated.
std::vector<CellSpecies> withMeanVolumes(std::vector<CellSpecies> species, const MeanVolumes& means,
                                         std::optional<double> redCellVolume);

/// The species with these numbers of cells.
std::vector<CellSpecies> withCounts(std::vector<CellSpecies> species,
                                    const std::vector<std::int64_t>& counts);

/// Examines whether so many cells can be there. Pre: the species have their numbers
/// @throws InputError if cells fit nowhere in the lumen, if HemoCell would delete every one of a kind, or if
///   they fill more of the lumen than there is, or than any known packing does
void examineNumbers(const Scene& scene, Notices& notices);

}  // namespace packmesh::hemocell
