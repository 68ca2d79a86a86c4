// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Data that a problem takes from the C++ code of its case.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/case.h"
#include "hemocell_adapter/hemocell/pre_inlet.h"
#include "hemocell_adapter/problem/cell_species.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

/// The place of the pre-inlet: as requested, otherwise from the code; empty if none is packed. A
/// contradiction and a slice that is not read cause a warning.
/// @throws UsageError, InputError if it cannot be determined
std::optional<PreInletPlace> choosePreInlet(const Request& request, const Case* simulation,
                                            std::vector<std::string>& warnings);

/// The species with their minimum distances from solid: as specified, otherwise from the code (or of the
/// running system), otherwise 0; warnings as above, and if there is no code.
std::vector<SpeciesPlan> withDistancesFromSolid(const Case& simulation, std::vector<SpeciesPlan> all,
                                                std::vector<std::string>& warnings);

/// Warnings about walls and periodic axes that the code sets and that packing does not know.
std::vector<std::string> unreadWalls(const Request& request, const Case* simulation);

}  // namespace packmesh::hemocell
