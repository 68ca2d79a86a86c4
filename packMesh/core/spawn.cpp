// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/spawn.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace packmesh {
namespace {

std::vector<char*> pointersTo(const std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (const std::string& text : texts) pointers.push_back(const_cast<char*>(text.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

/// What is done to the files of a process before its program starts.
class FileActions {
 public:
  FileActions() : error_(posix_spawn_file_actions_init(&actions_)), made_(error_ == 0) {}
  ~FileActions() {
    if (made_) posix_spawn_file_actions_destroy(&actions_);
  }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;

  int set(const std::vector<int>& descriptors) {
    const int n = static_cast<int>(descriptors.size());
    for (int k = 0; k < n && error_ == 0; ++k)
      error_ = descriptors[k] < 0 ? posix_spawn_file_actions_addopen(&actions_, k, "/dev/null", O_RDWR, 0)
                                  : posix_spawn_file_actions_adddup2(&actions_, descriptors[k], k);
#if __GLIBC_PREREQ(2, 34)
    if (error_ == 0) error_ = posix_spawn_file_actions_addclosefrom_np(&actions_, n);  // of MPI, locks ...
#endif
    return error_;
  }
  const posix_spawn_file_actions_t* get() const {
    return &actions_;
  }

 private:
  posix_spawn_file_actions_t actions_;
  int error_;
  bool made_;
};

/// Signals and the group of a process.
class Attributes {
 public:
  Attributes() : error_(posix_spawnattr_init(&attributes_)), made_(error_ == 0) {}
  ~Attributes() {
    if (made_) posix_spawnattr_destroy(&attributes_);
  }
  Attributes(const Attributes&) = delete;
  Attributes& operator=(const Attributes&) = delete;

  int set(const std::vector<int>& blockedSignals, bool ownGroup) {
    if (error_ != 0) return error_;
    sigset_t blocked, byDefault;
    sigemptyset(&blocked);
    for (const int number : blockedSignals) sigaddset(&blocked, number);
    sigfillset(&byDefault);
    posix_spawnattr_setsigmask(&attributes_, &blocked);
    posix_spawnattr_setsigdefault(&attributes_, &byDefault);
    posix_spawnattr_setpgroup(&attributes_, 0);
    return posix_spawnattr_setflags(&attributes_,
                                    static_cast<short>(POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF |
                                                       (ownGroup ? POSIX_SPAWN_SETPGROUP : 0)));
  }
  const posix_spawnattr_t* get() const { return &attributes_; }

 private:
  posix_spawnattr_t attributes_;
  int error_;
  bool made_;
};

}  // namespace

int spawn(const StartedProgram& program, pid_t& id) {
  FileActions files;
  Attributes attributes;
  if (const int error = files.set(program.descriptors)) return error;
  if (const int error = attributes.set(program.blockedSignals, program.ownGroup)) return error;
  const std::vector<char*> words = pointersTo(program.words), environment = pointersTo(program.environment);
  return posix_spawnp(&id, words[0], files.get(), attributes.get(), words.data(), environment.data());
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
