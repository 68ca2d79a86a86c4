// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which species are packed, and what is stated of each.
#pragma once

#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/case.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

/// Whether its volume counts in the hematocrit: as stated, or by its name.
bool isRedCell(const SpeciesRequest& request);

/// Replaces state files by requests for the species in them.
/// @return whether cells in them have meshes of their own @throws InputError
bool nameSpeciesOfStates(Request& request);

/// Completes the species to pack: those of `<packing>` and of the options, plus RBC (and PLT) if a hematocrit
/// requires them. Clears the hematocrit where counts of the options replace one of a file.
/// @param request with everything that is stated @param options those of the command line alone, which take
/// precedence @param simulation nullptr: none
/// @throws UsageError, InputError
void completeSpecies(Request& request, const Request& options, const Case* simulation,
                     std::vector<std::string>& warnings);

}  // namespace packmesh::hemocell
