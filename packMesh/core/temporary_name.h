// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Names of files that are written before they replace others.
#pragma once

#include <filesystem>
#include <string>

namespace packmesh {

/// `.<name>.<host>.<process>-<number>.<kind>` next to `target`: no other process has it, and no file system
/// finds it too long; of a long name of the target the beginning is taken.
std::filesystem::path temporaryName(const std::filesystem::path& target, int number, const std::string& kind);

/// How the names of all temporary files of `target` begin, whichever process made them.
std::string temporaryPrefix(const std::filesystem::path& target);

/// This machine, and as which process: "node7", 4711.
std::string hostName();
long processNumber();

}  // namespace packmesh
