// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Starting other programs, by any thread and without fork().
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "packMesh/core/descriptor.h"

namespace packmesh {

/// A program may be given descriptors 0-3. Ours that it gets are not below this, so that none is overwritten.
constexpr int leastOwnDescriptor = 4;

struct StartedProgram {
  std::vector<std::string> words;  ///< the program, looked for in PATH if it has no slash, and its arguments
  std::vector<std::string> environment = {};  ///< "NAME=value"
  /// Ours that become its 0, 1, ...; -1 is /dev/null. All others are closed in it (glibc before 2.34: those
  /// that are marked so).
  std::vector<int> descriptors = {};
  std::vector<int> blockedSignals = {};  ///< all others act in the default way
  bool ownGroup = false;                 ///< it is the first of a new process group
};

/// @return 0, or the number of an error of the system; `id` is that of the process
int spawn(const StartedProgram& program, pid_t& id);

/// Waits for the end of a process of ours. @return its status as of waitpid(); empty where SIGCHLD is ignored
std::optional<int> statusAtEnd(pid_t id);

/// Both ends, ours (see leastOwnDescriptor). @return false, with errno, if not possible
bool makePipe(Descriptor& read, Descriptor& write);

/// Whether this is a file that this user may execute.
bool isProgram(const std::filesystem::path& file);

}  // namespace packmesh
