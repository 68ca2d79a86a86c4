// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What a command line and a case ask for, with defaults and contradictions settled.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/case.h"
#include "hemocell_adapter/hemocell/pre_inlet.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

/// A request for a case or for none, of which nothing is left open.
struct CompletedRequest {
  Request request;
  std::shared_ptr<const Case> simulation;  ///< nullptr: none
  std::optional<PreInletPlace> preInlet;   ///< of a case whose pre-inlet is packed
  std::vector<std::string> warnings;       ///< how the input was interpreted, for the user
};

/// What is to be packed: the `<packing>` section of the case, overridden by what a front end states.
/// @param running inside HemoCell: the case, of which no file is read; otherwise that of the request
/// @throws UsageError, InputError
CompletedRequest requestToPack(const Request& asked, std::shared_ptr<const Case> running = nullptr);

/// What is to be checked. @param folder of the .pos files, regardless of other settings
/// @throws UsageError, InputError
CompletedRequest requestToCheck(const Request& asked,
                                const std::optional<std::filesystem::path>& folder = {});

/// What `check` examines if its folder has realisations: .pos files beside them, and each of them; else
/// nothing. @throws UsageError if outputs are requested, which are of one folder
std::vector<std::filesystem::path> foldersToCheck(const Request& request);

}  // namespace packmesh::hemocell
