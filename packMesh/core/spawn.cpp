// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/spawn.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <system_error>

namespace packmesh {
namespace {

std::vector<char*> pointersTo(const std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (const std::string& text : texts) pointers.push_back(const_cast<char*>(text.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

/// What is done to the files of a process before its program starts. @return 0, or the number of an error
int setFiles(posix_spawn_file_actions_t& actions, const std::vector<int>& descriptors) {
  const int n = static_cast<int>(descriptors.size());
  int error = 0;
  for (int k = 0; k < n && error == 0; ++k)
    error = descriptors[k] < 0 ? posix_spawn_file_actions_addopen(&actions, k, "/dev/null", O_RDWR, 0)
                               : posix_spawn_file_actions_adddup2(&actions, descriptors[k], k);
#if __GLIBC_PREREQ(2, 34)
  if (error == 0) error = posix_spawn_file_actions_addclosefrom_np(&actions, n);  // of MPI, locks ...
#endif
  return error;
}

/// Signals and the group of a process. @return 0, or the number of an error
int setAttributes(posix_spawnattr_t& attributes, const std::vector<int>& blockedSignals, bool ownGroup) {
  sigset_t mask, byDefault;
  sigemptyset(&mask);
  for (const int number : blockedSignals) sigaddset(&mask, number);
  sigfillset(&byDefault);
  posix_spawnattr_setsigmask(&attributes, &mask);
  posix_spawnattr_setsigdefault(&attributes, &byDefault);
  posix_spawnattr_setpgroup(&attributes, 0);
  return posix_spawnattr_setflags(&attributes,
                                  static_cast<short>(POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF |
                                                     (ownGroup ? POSIX_SPAWN_SETPGROUP : 0)));
}

/// Ends what a function of the system has begun.
template <class T>
using Ended = std::unique_ptr<T, int (*)(T*)>;

}  // namespace

int spawn(const StartedProgram& program, pid_t& id) {
  posix_spawn_file_actions_t files;
  if (const int error = posix_spawn_file_actions_init(&files)) return error;
  const Ended<posix_spawn_file_actions_t> endFiles(&files, posix_spawn_file_actions_destroy);
  if (const int error = setFiles(files, program.descriptors)) return error;
  posix_spawnattr_t attributes;
  if (const int error = posix_spawnattr_init(&attributes)) return error;
  const Ended<posix_spawnattr_t> endAttributes(&attributes, posix_spawnattr_destroy);
  if (const int error = setAttributes(attributes, program.blockedSignals, program.ownGroup)) return error;
  const std::vector<char*> words = pointersTo(program.words), environment = pointersTo(program.environment);
  return posix_spawnp(&id, words[0], &files, &attributes, words.data(), environment.data());
}

std::optional<int> statusAtEnd(pid_t id) {
  int status = 0;
  pid_t ended;
  while ((ended = waitpid(id, &status, 0)) < 0 && errno == EINTR) continue;
  return ended == id ? std::optional<int>(status) : std::nullopt;
}

bool makePipe(Descriptor& read, Descriptor& write) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return false;
  read = Descriptor(ends[0]);
  write = Descriptor(ends[1]);
  return read.raise(leastOwnDescriptor) && write.raise(leastOwnDescriptor);
}

bool isProgram(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(file, ignored) && access(file.c_str(), X_OK) == 0;
}

}  // namespace packmesh
