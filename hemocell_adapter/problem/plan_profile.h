// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file From the profile that is asked for to shells in which cells are packed, and what was reached.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/problem.h"
#include "hemocell_adapter/settings/request.h"

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

/// How the cells are distributed so that their volume has the profile that is asked for.
///
/// A cell extends over several layers, so the volume of cells whose centre is in a shell is spread over its
/// surroundings. Random poses that fit the lumen show how; the numbers of cells in the shells follow by
/// deconvolution (Richardson 1972, Lucy 1974: the expectation maximisation of a mixture). The numbers of
/// cells are those of the species. Every rank computes the same. Pre: the species have their numbers, and the
/// request asks for a profile
/// @throws InputError if there is no wall, or if nothing that is packed has a profile
std::shared_ptr<const DepthProfile> planProfile(const Scene& scene, std::vector<std::string>& notices);

/// @throws InputError if a shell would hold more cells than can be packed
void refuseTooDense(const Scene& scene, const DepthProfile& profile);

/// The profile of a problem with the numbers of cells corrected by a packing of it, in which cells are not
/// where random ones would be: in the core they press outwards. The same on all ranks, which all call.
/// @param packed from the problem at the clearances demanded: all its cells, of which this rank has its share
std::shared_ptr<const DepthProfile> correctedProfile(const Problem& problem, const PackingResult& packed);

/// Volume fractions of each species with a profile in each shell, [species][shell]; empty for others. The
/// same on all ranks, which all call. @param cells of this rank, named by the species of the problem
std::vector<std::vector<double>> reachedProfile(const Problem& problem, const std::vector<PlacedCell>& cells);

}  // namespace packmesh::hemocell
