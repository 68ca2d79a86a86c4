// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which species are packed, and what is to be built and read for each.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/case.h"
#include "hemocell_adapter/problem/cell_species.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

/// Whether its volume counts in the hematocrit: as stated, or by its name.
bool isRedCell(const SpeciesRequest& request);

/// The species of a request, with those in its state files.
struct SpeciesOfStates {
  std::vector<SpeciesRequest> species;
  bool deformed = false;  ///< cells in the files have meshes of their own
};
/// @throws InputError
SpeciesOfStates speciesWithStates(const Request& request);

/// The species to pack, and the hematocrit that determines the number of one of them.
struct SpeciesToPack {
  std::vector<SpeciesRequest> species;
  std::optional<double> hematocrit;
};
/// Those that are stated, plus RBC (and PLT) if a hematocrit requires them. Of a hematocrit and the number of
/// red cells, what is stated later replaces the other.
/// @param simulation nullptr: none
/// @throws UsageError, InputError
SpeciesToPack chooseSpecies(const Request& request, const Case* simulation,
                            std::vector<std::string>& warnings);

/// What is to be built of each species of a complete request. Reads existing cells, and `<Cell>.xml`.
/// @throws UsageError, InputError
std::vector<SpeciesPlan> plansToPack(const Request& request, const Case* simulation,
                                     std::vector<std::string>& warnings);

struct CheckedSpecies {
  std::vector<SpeciesPlan> plans;
  std::vector<std::string> unchecked;  ///< .pos files of cells whose template cannot be determined
};

/// The species to check: one for each .pos file in a folder, or kind of cell in the states to start from.
/// @throws InputError if there are none
CheckedSpecies plansToCheck(const Request& request, const Case* simulation,
                            const std::filesystem::path& folder, std::vector<std::string>& warnings);

}  // namespace packmesh::hemocell
