// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How many cells a hematocrit is.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace packmesh::hemocell {

/// One kind of cell as far as its number is concerned.
struct CountedSpecies {
  std::string name;
  double volume = 0.0;  ///< by which it counts [µm³]
  bool redCell = false;
  std::optional<std::int64_t> count;
  std::optional<double> ratio;  ///< per red cell, those of all species counted
};

/// The number of cells of each kind.
///
/// A ratio is the number of cells per red cell, where the red cells of all species count. Of a red species it
/// is therefore the share of these cells among all red cells (a parasitaemia, say). With a hematocrit, the
/// red species without count and ratio gets the number that brings the volume of all red cells nearest to
/// hematocrit · lumenVolume.
/// @throws InputError when nothing is to be packed, several species wait for the hematocrit, the red cells
/// with
///   counts exceed it, or the ratios of red species add up to 1 or more
std::vector<std::int64_t> countCells(const std::vector<CountedSpecies>& species,
                                     std::optional<double> hematocrit, double lumenVolume);

}  // namespace packmesh::hemocell
