// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Running the program, in this process or as the executable.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/temporary_folder.h"

namespace packmesh::test {

void writeText(const std::filesystem::path& file, const std::string& text);
nlohmann::json parseJson(const std::string& text);
nlohmann::json readJson(const std::filesystem::path& file);
/// How many cells a .pos file announces; -1: it does not.
int cellsIn(const std::filesystem::path& file);

/// A path, or the folder of a test.
struct Folder : std::filesystem::path {
  Folder(const std::filesystem::path& there) : std::filesystem::path(there) {}
  Folder(const TemporaryFolder& folder) : std::filesystem::path(folder.path()) {}
};

inline std::filesystem::path operator/(const TemporaryFolder& folder, const std::string& name) {
  return folder.path() / name;
}

struct Ran {
  int exitCode = -1;
  std::string out, err;
  std::string all() const { return out + err; }
};

/// What `packMesh` (or `packCells`) does in `folder`, by the function that its main() calls, in this process.
/// @param arguments as a shell splits them
Ran run(const Folder& folder, const std::string& arguments, const std::string& program = "packMesh");

/// The same, and requires this exit code.
Ran ended(const Folder& folder, int exitCode, const std::string& arguments,
          const std::string& program = "packMesh");
Ran ok(const Folder& folder, const std::string& arguments);
/// Requires it of a run.
Ran withExit(int exitCode, Ran ran);

/// Starts the executable: for what only a process shows.
/// @param prefix put before the program: variables, timeout, mpirun; all that these start has ended
/// afterwards
Ran runProcess(const Folder& folder, const std::string& arguments, const std::string& prefix,
               const std::string& program = "packMesh");

/// Prefix for what must have ended, with all that it starts, when the next command begins.
std::string awaitingAll();

/// Prefix for several ranks, as on a machine with fewer processors than those. Open MPI leaks: tests of
/// mpi_tests look for leaks on ranks.
/// @param grace from SIGTERM to SIGKILL, which mpirun sends to all ranks when one has failed or mpirun itself
/// is to end [s]. None, if the ranks need none: a busy machine would not always give it, and mpirun takes it
/// whether the ranks do or not.
std::string onRanks(int ranks, int grace = 0);

}  // namespace packmesh::test
