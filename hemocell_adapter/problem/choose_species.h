// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The kinds of cells of a problem.
#pragma once

#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/case.h"
#include "hemocell_adapter/problem/cell_species.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

/// Replaces state files by requests for the species in them. @throws InputError
void nameSpeciesOfStates(Request& request);

/// Completes the species to pack: those of `<packing>` and of the options, plus RBC (and PLT) if a hematocrit
/// requires them. Clears the hematocrit where counts of the options replace one of a file.
/// @param request with everything that is stated @param options those of the command line alone, which take
/// precedence @param simulation nullptr: none
/// @throws UsageError, InputError
void completeSpecies(Request& request, const Request& options, const Case* simulation,
                     std::vector<std::string>& warnings);

/// What is to be built of each species of a complete request. Reads existing cells, and `<Cell>.xml`.
/// @throws UsageError, InputError
std::vector<SpeciesPlan> plansToPack(const Request& request, const Case* simulation,
                                     std::vector<std::string>& warnings);

struct CheckedSpecies {
  std::vector<SpeciesPlan> plans;
  std::vector<std::string> unchecked;  ///< .pos files of cells whose template cannot be determined
};

/// The species to check: one for each .pos file in the folder, or kind of cell in the states to start from.
/// @throws InputError if there are none
CheckedSpecies plansToCheck(const Request& request, const Case* simulation,
                            std::vector<std::string>& warnings);

}  // namespace packmesh::hemocell
