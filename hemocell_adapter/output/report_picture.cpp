// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/report_picture.h"

#include <fcntl.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include "hemocell_adapter/base/log.h"

extern char** environ;

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

class ScratchFolder {
 public:
  ScratchFolder() {
    std::string pattern = (fs::temp_directory_path() / "packMesh-XXXXXX").string();
    if (::mkdtemp(pattern.data()) != nullptr) path_ = pattern;
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// @return exit code; -1: there is no such program
int runQuietly(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (const int descriptor : {STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&actions, descriptor, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  pid_t child = 0;
  const int error = posix_spawnp(&child, words[0].c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return -1;
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return 1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace

Picture renderPicture(const std::function<void(const fs::path&)>& writeScene) {
  const std::string help = " packMesh --pov writes a scene; python3 -m packmesh render renders it.";
  if (runQuietly({"povray", "--version"}) < 0)
    return {"", "No picture: POV-Ray is not installed (Debian: apt install povray)." + help};
  const ScratchFolder folder;
  if (folder.path().empty()) return {"", "No picture: there is no folder for temporary files." + help};
  const fs::path scene = folder.path() / "cells.pov", png = folder.path() / "cells.png";
  writeScene(scene);
  log::detail("Rendering the picture of the report");
  const int code = runQuietly({"povray", "+I" + scene.string(), "+O" + png.string(), "+W1200", "+H800",
                               "+A0.2", "+AM2", "+R2", "-D", "-GA"});
  std::ifstream file(png, std::ios::binary);
  Picture picture{{std::istreambuf_iterator<char>(file), {}}, ""};
  if (code != 0 || picture.png.empty()) return {"", "No picture: POV-Ray could not render it." + help};
  return picture;
}

}  // namespace packmesh::hemocell
