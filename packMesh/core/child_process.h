// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Work that can be given up at any moment.
#pragma once

#include <functional>
#include <string>

namespace packmesh {

struct ChildOutcome {
  enum class End {
    done,
    stopped,  ///< given up
    died,     ///< a signal ended it (too little memory, a crash)
  };
  End end = End::done;
  std::string bytes;  ///< what the work returned, when done
};

/// Does `work` in a child process, which shares nothing with this one from then on, and waits for what it
/// returns. Where no process can be started, the work is done in this one.
/// @param work must not throw, communicate with other ranks, or rely on what it leaves behind in memory
/// @param stop polled before, and some 20 times a second; true ends the child. Empty: never
ChildOutcome inChildProcess(const std::function<std::string()>& work, const std::function<bool()>& stop);

}  // namespace packmesh
