// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The command in a state file, which may be moved together with the files beside it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace packmesh::hemocell {

/// The words as a state file stores them: absolute paths of files in its folder begin with "{folder}"
/// instead.
std::vector<std::string> storedWords(std::vector<std::string> words, const std::filesystem::path& state);

/// The words that a state file stores, with the folder in which it is now.
std::vector<std::string> wordsNow(std::vector<std::string> words, const std::filesystem::path& state);

/// Whether the words are no command, but name the iteration of the simulation whose cells a state has.
bool isOfSimulation(const std::vector<std::string>& words);

/// @throws InputError if the words are no command, but name the iteration of the simulation whose cells it
/// has
void requireCommand(const std::vector<std::string>& words, const std::filesystem::path& state);

}  // namespace packmesh::hemocell
