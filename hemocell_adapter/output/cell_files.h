// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The files that contain the cells for HemoCell.
#pragma once

#include <filesystem>
#include <vector>

#include "hemocell_adapter/output/packing.h"

namespace packmesh::hemocell {

/// Writes them, all or none, and with them the state of the result. Every rank writes its cells, in the order
/// of the ranks. A species of which cells have meshes of their own has no file. What an earlier packing has
/// left under the names of species that have no .pos file now, or has written with the state that is
/// replaced, is renamed to RBC.pos.old. All ranks call.
/// @param output where @param withState that of the packing; otherwise an older state file is renamed
/// @return the .pos files
/// @throws AgreedFailure, OutputError on all ranks if they cannot be written; then no file has changed
std::vector<std::filesystem::path> writeCellFiles(const Packing& packing, const OutputRequest& output,
                                                  bool withState);

}  // namespace packmesh::hemocell
