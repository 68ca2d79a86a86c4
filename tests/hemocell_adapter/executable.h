// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Running the real executable in a folder of its own.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/catch.h"
#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"

namespace packmesh::test {

inline void writeText(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

struct Ran {
  int exitCode = -1;
  std::string out, err;
  std::string all() const { return out + err; }
};

/// Prefix for what must have ended, with all that it starts, when the next command begins.
inline std::string awaitingAll() {
  return "'" + (std::filesystem::path(programFolder) / "await_all").string() + "'";
}

/// Runs `packMesh` (or `packCells`) in `folder` with arguments as a shell splits them.
/// @param prefix put before the program: variables, timeout, mpirun; all that these start has ended
/// afterwards
inline Ran run(const std::filesystem::path& folder, const std::string& arguments,
               const std::string& program = "packMesh", const std::string& prefix = "") {
  const std::filesystem::path executable = std::filesystem::path(programFolder) / program;
  const TemporaryFolder output;
  const std::string awaited = prefix.empty() ? "" : awaitingAll() + " env " + prefix;
  const std::string command = "cd '" + folder.string() + "' && " + awaited + " '" + executable.string() +
                              "' " + arguments + " > '" + (output.path() / "out").string() + "' 2> '" +
                              (output.path() / "err").string() + "'";
  const int status = std::system(command.c_str());
  Ran ran;
  ran.exitCode = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  ran.out = readText(output.path() / "out");
  ran.err = readText(output.path() / "err");
  return ran;
}

/// Runs what must succeed.
inline Ran ok(const TemporaryFolder& folder, const std::string& arguments) {
  Ran ran = run(folder.path(), arguments);
  INFO(ran.all());
  REQUIRE(ran.exitCode == 0);
  return ran;
}

/// How many cells a .pos file announces; -1: it does not.
inline int cellsIn(const std::filesystem::path& file) {
  std::ifstream in(file);
  int n = -1;
  in >> n;
  return n;
}

/// Prefix for several ranks, as on a machine with fewer processors than those. Open MPI leaks: tests of
/// mpi_tests look for leaks on ranks.
/// @param grace from SIGTERM to SIGKILL, which mpirun sends to all ranks when one has failed or mpirun itself
/// is to end [s]. None, if the ranks need none: a busy machine would not always give it, and mpirun takes it
/// whether the ranks do or not.
inline std::string onRanks(int ranks, int grace = 0) {
  return "ASAN_OPTIONS=detect_leaks=0 OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 "
         "OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_mpi_yield_when_idle=1 "
         "PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe "
         "OMPI_MCA_odls_base_sigkill_timeout=" +
         std::to_string(grace) + " PRTE_MCA_odls_base_sigkill_timeout=" + std::to_string(grace) +
         " timeout " + std::to_string(timeout / 2) + " mpirun -n " + std::to_string(ranks);
}

}  // namespace packmesh::test
