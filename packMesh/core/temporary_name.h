// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Names of temporary files that replace other files once they are complete.
#pragma once

#include <filesystem>
#include <string>

namespace packmesh {

/// `.<name>~<host>.<process>-<number>.<kind>` next to `target`: unique to this process and short enough for
/// every file system; a long target name is replaced by a hash.
std::filesystem::path temporaryName(const std::filesystem::path& target, int number, const std::string& kind);

/// True if `file` is a temporary file of `target`, of any process.
bool isTemporaryOf(const std::filesystem::path& file, const std::filesystem::path& target,
                   const std::string& kind);

/// True if `file` is a temporary file of a process of this machine that has ended.
bool isAbandoned(const std::filesystem::path& file, const std::string& kind);

/// The name of a lock on `target`, next to it.
std::filesystem::path lockName(const std::filesystem::path& target);

/// Name of this machine and id of this process: "node7", 4711.
std::string hostName();
long processNumber();

}  // namespace packmesh
