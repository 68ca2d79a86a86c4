// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which .pos files belong to the packing of a state, and which to another one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

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

}  // namespace packmesh::hemocell
