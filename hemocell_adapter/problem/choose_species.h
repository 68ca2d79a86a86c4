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

/// Completes the species to pack: those that are stated, plus RBC (and PLT) if a hematocrit requires them. Of
/// a hematocrit and the number of red cells, what is stated later replaces the other.
/// @param simulation nullptr: none
/// @throws UsageError, InputError
void completeSpecies(Request& request, const Case* simulation, std::vector<std::string>& warnings);

}  // namespace packmesh::hemocell
