// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Running the real executable in a folder of its own.
#pragma once

#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace packmesh::test {

/// A new folder that disappears with the object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "packmesh-XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline void writeText(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

inline std::string readText(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

struct Ran {
  int exitCode = -1;
  std::string out, err;
  std::string all() const { return out + err; }
};

/// Runs `packMesh` (or `packCells`) in `folder` with arguments as a shell splits them.
/// @param prefix put before the program: variables, timeout
inline Ran run(const std::filesystem::path& folder, const std::string& arguments,
               const std::string& program = "packMesh", const std::string& prefix = "") {
  const std::filesystem::path executable = std::filesystem::path(PACKMESH_BIN_DIR) / program;
  const TemporaryFolder output;
  const std::string command = "cd '" + folder.string() + "' && " + prefix + " '" + executable.string() +
                              "' " + arguments + " > '" + (output.path() / "out").string() + "' 2> '" +
                              (output.path() / "err").string() + "'";
  const int status = std::system(command.c_str());
  Ran ran;
  ran.exitCode = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  ran.out = readText(output.path() / "out");
  ran.err = readText(output.path() / "err");
  return ran;
}

}  // namespace packmesh::test
