// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What a command line and a case ask for, with defaults and contradictions settled.
#pragma once

#include <memory>
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

/// A request for a case or for none, of which nothing is left open, apart from what is written
/// (output/output_plan.h).
struct CompletedRequest {
  Request request;
  std::shared_ptr<const Case> simulation;  ///< nullptr: none
  std::optional<PreInletPlace> preInlet;   ///< of a case whose pre-inlet is packed
  std::vector<std::string> warnings;       ///< how the input was interpreted, for the user
  bool deformed = false;                   ///< cells of states have meshes of their own
};

/// What is to be packed: the `<packing>` section of the case, overridden by what a front end states.
/// @param running inside HemoCell: the case, of which no file is read; otherwise that of the request
/// @throws UsageError, InputError
CompletedRequest requestToPack(const Request& asked, std::shared_ptr<const Case> running = nullptr);

/// What is to be checked.
/// @throws UsageError, InputError
CompletedRequest requestToCheck(const Request& asked);

}  // namespace packmesh::hemocell
