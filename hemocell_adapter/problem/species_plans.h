// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What is to be built and read for each species of a request.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/case.h"
#include "hemocell_adapter/problem/cell_species.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

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
