// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What a command line and a case ask for, with defaults and contradictions settled.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/case.h"
#include "hemocell_adapter/hemocell/pre_inlet.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

/// A request for a case or for none, of which nothing is left open, apart from what is written
/// (output/requested_outputs.h).
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
