// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Runs work in a child process that can be stopped at any time.
#pragma once

#include <functional>
#include <string>

namespace packmesh {

struct ChildOutcome {
  enum class End {
    done,
    stopped,  ///< ended because stop() returned true
    died,     ///< killed by a signal (out of memory, crash)
  };
  End end = End::done;
  std::string bytes;  ///< return value of the work if `done`
};

/// Runs `work` in a child process, which shares no memory with this one, and waits for its result. If no
/// process can be started, runs `work` in this process.
/// @param work must not throw, communicate with other ranks, or rely on changes it makes to memory
/// @param stop polled before the start and about 20 times per second; true kills the child. Empty: never stop
ChildOutcome inChildProcess(const std::function<std::string()>& work, const std::function<bool()>& stop);

}  // namespace packmesh
