// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Requests in state files, which may be moved together with the files beside them.
#pragma once

#include <filesystem>

#include "hemocell_adapter/settings/request.h"
#include "packMesh/packing/state_file.h"

namespace packmesh::hemocell {

/// What a state says of a request: JSON (request_json.h) without --restart, and the numbers that were given.
/// Absolute paths of files in its folder become {"beside": relative path}, names that are not UTF-8 {"bytes":
/// [...]}.
StateRecord recordOf(const Request& request, const std::filesystem::path& state);

/// The request of a state, with the folder in which it is now.
/// @throws InputError if the state has none: it has the cells of a simulation, or is of version 2
Request requestIn(const StateRecord& record, const std::filesystem::path& state);

}  // namespace packmesh::hemocell
