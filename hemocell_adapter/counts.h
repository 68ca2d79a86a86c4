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
  std::optional<double> ratio;  ///< per red cell
};

/// The number of cells of each kind.
///
/// With a hematocrit, the red species without count and ratio gets the number that brings the volume of all
/// red cells nearest to hematocrit · lumenVolume. A ratio counts per red cell, all red species without ratio
/// together.
/// @throws InputError when nothing is to be packed, several species wait for the hematocrit, or the fixed red
///   cells already exceed it
std::vector<std::int64_t> countCells(const std::vector<CountedSpecies>& species,
                                     std::optional<double> hematocrit, double lumenVolume);

}  // namespace packmesh::hemocell
