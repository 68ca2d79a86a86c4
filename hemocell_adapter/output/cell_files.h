// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The files that contain the cells for HemoCell.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hemocell_adapter/output/packing.h"

namespace packmesh::hemocell {

/// Whether a .pos file has cells; the plug-in leaves files that only have their number.
bool hasCells(const std::filesystem::path& posFile);

/// Whether two files are in the same folder.
bool isBeside(const std::filesystem::path& file, const std::filesystem::path& other);

/// Names of the .pos files with cells that are in the folder of a state.
struct PosFilesBeside {
  std::vector<std::string> same;   ///< as they were written with it
  std::vector<std::string> other;  ///< changed since, or never written with it
};

/// Both are empty if the file is not a readable state, or no .pos file was written with it. One rank calls.
PosFilesBeside filesOfState(const std::filesystem::path& state);

/// What to tell the user if a folder has .pos files that were written with a state there, and others. One
/// rank calls.
std::vector<std::string> warningsOfTwoRuns(const std::filesystem::path& folder);

/// Writes them, all or none, and with them the state of the result. Every rank writes its cells, in the order
/// of the ranks. A species of which cells have meshes of their own has no file. What an earlier packing has
/// left under the names of species that have no .pos file now, or has written with the state that is
/// replaced, is renamed to RBC.pos.old. All ranks call.
/// @param output where @param withState that of the packing; otherwise an older state file is renamed
/// @return the .pos files
/// @throws AgreedFailure, OutputError on all ranks if they cannot be written; then no file has changed
std::vector<std::filesystem::path> writeCellFiles(const Packing& packing, const OutputRequest& output,
                                                  bool withState);

/// Warns if HemoCell would delete some of the cells when it loads them from the files, and if there are .pos
/// files of another packing beside them. All ranks call.
void warnOfCellFiles(const Packing& packing, const std::filesystem::path& folder);

}  // namespace packmesh::hemocell
