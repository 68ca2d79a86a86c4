// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The files that contain the cells for HemoCell.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "hemocell_adapter/problem/problem.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Writes them, all or none. Every rank writes its cells, in the order of the ranks. All ranks call.
/// @param counts of all ranks, per species
/// @return the files
/// @throws AgreedFailure if they cannot be written; then no file has changed
std::vector<std::filesystem::path> writeCellFiles(const Problem& problem, const OutputRequest& output,
                                                  const PackingResult& result,
                                                  const std::vector<std::int64_t>& counts);

}  // namespace packmesh::hemocell
