// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The files that contain the cells for HemoCell.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/problem/problem.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Writes them, all or none, and with them the state of the result. Every rank writes its cells, in the order
/// of the ranks. A species of which cells have meshes of their own has no file. What an earlier packing has
/// left under the names of species that have no .pos file now, or has written with the state that is
/// replaced, is renamed to RBC.pos.old. All ranks call.
/// @param counts of all ranks, per species
/// @param state nothing: an older state file is renamed
/// @return the .pos files
/// @throws AgreedFailure, OutputError on all ranks if they cannot be written; then no file has changed
std::vector<std::filesystem::path> writeCellFiles(const Problem& problem, const OutputRequest& output,
                                                  const PackingResult& result,
                                                  const std::vector<std::int64_t>& counts,
                                                  const std::optional<ResultState>& state = {});

}  // namespace packmesh::hemocell
