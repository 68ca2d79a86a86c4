// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Profiles as they are asked for: relative concentrations over the distance from the wall.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/settings/source.h"

namespace packmesh::hemocell {

/// Relative concentrations of species, linear between some distances and constant beyond the last.
struct ProfileSource {
  struct Column {
    std::string species;
    std::vector<double> value;  ///< at each distance; only their ratios matter
  };
  std::string source;            ///< for people
  std::vector<double> distance;  ///< from the wall, ascending [µm; or fraction of the largest one]
  bool isFraction = false;       ///< of the largest distance from the wall in the lumen: in a tube its radius
  std::vector<Column> columns;

  /// Of a column. @param distance [as `distance`]
  double at(const Column& column, double distance) const;
  const Column* columnOf(const std::string& species) const;
};

/// Reads a table: a line with `distance` (or `fraction`) and the names of cells, then lines of numbers, with
/// blanks, tabs or commas between them; # begins a comment. Or numbers in memory, a table for each column.
/// @throws InputError
ProfileSource readProfile(const Source& source);

/// Profile of developed flow.
///
/// Red cells: none up to half of the thickness of the cell-free layer that follows from the Fåhraeus effect
/// (freeLayerOf()), evenly distributed from one and a half of it on, linear between them. The mean thickness
/// of the layer is kept, and its edge is as wide as rigid cells need.
/// Platelets: five times as concentrated in the layer as in the core, linear between once and twice its
/// thickness. Measured: at least 3 times in channels of 30 to 100 µm (Tilles, Eckstein: Microvascular
/// Research 33, 211-223, 1987), 2.4 to 3.3 times in a channel of 100 µm, up to 7 times the mean in tubes of
/// 100 to 500 µm (Uijttewaal, Nijhof, Bronkhorst, Den Hartog, Heethaar: Am. J. Physiol. 264, H1239-H1244,
/// 1993).
/// @param tubeHematocrit of the lumen @param diameter of the lumen [µm]
ProfileSource developedFlow(double tubeHematocrit, double diameter, const std::vector<std::string>& redCells,
                            const std::vector<std::string>& platelets);

}  // namespace packmesh::hemocell
