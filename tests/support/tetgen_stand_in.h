// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A script in place of packmesh-tetgen.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "packMesh/cat/tetgen_run.h"
#include "tests/support/temporary_folder.h"

namespace packmesh::test {

class TetgenStandIn {
 public:
  /// @param run the shell script of a run
  /// @param version that of `--version`; by default it is right
  explicit TetgenStandIn(const std::string& run, const std::string& version = "exec " + real() + " --version")
      : file_(folder_.path() / "packmesh-tetgen"),
        variable_("PACKMESH_TETGEN",
                  (std::ofstream(file_) << "#!/bin/sh\n[ \"$1\" = --version ] && { " << version << "; }\n"
                                        << run << "\n",
                   std::filesystem::permissions(file_, std::filesystem::perms::owner_all), file_.string())) {}

  /// The path of the program, as a shell reads it.
  static std::string real() { return "'" + tetgenProgram() + "'"; }

 private:
  TemporaryFolder folder_;
  std::filesystem::path file_;
  Variable variable_;
};

}  // namespace packmesh::test
