// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A full disk, imitated by a limit on the size of files.
#pragma once

#include <sys/resource.h>

#include <csignal>

namespace packmesh::test {

/// While it lives, this process writes at most 1000 bytes to a file.
class FullDisk {
 public:
  FullDisk() : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    struct rlimit small = before_;
    small.rlim_cur = 1000;
    ::setrlimit(RLIMIT_FSIZE, &small);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  struct rlimit before_ = {};
  void (*handler_)(int);
};

}  // namespace packmesh::test
