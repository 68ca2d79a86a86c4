// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file State files: written at intervals, on a signal and at the end; read by a restart.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "hemocell_adapter/settings/command_line.h"
#include "packMesh/packing/packing_problem.h"

namespace packmesh::hemocell {

/// The words of `arguments` or, if they only request a restart (`--restart file` and options), those of the
/// command that started the run, with these options appended. Any rank calls it on its own.
/// @throws UsageError, InputError
CommandLine parseOrContinue(const std::string& program, const std::vector<std::string>& arguments);

/// Tests before hours of packing. @throws OutputError if its folder is not writable, or the state file exists
/// and is not a state that may be replaced, or has the name of another output
void requireReplaceableState(const Request& request);

/// Writes the state of a run to the state file.
class StateFiles {
 public:
  /// References both, which must outlive it.
  StateFiles(const Request& request, const PackingProblem& problem) : request_(request), problem_(problem) {}
  StateFiles(const StateFiles&) = delete;
  StateFiles& operator=(const StateFiles&) = delete;

  Checkpoints checkpoints();
  /// Whether the last state has been written; empty if none was due.
  std::optional<bool> saved() const { return saved_; }

 private:
  void save(const PackingState& state);

  const Request& request_;
  const PackingProblem& problem_;
  std::optional<bool> saved_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// The state from which a run continues. All ranks call.
/// @throws InputError on all ranks
PackingState stateToContinue(const std::filesystem::path& file, const PackingProblem& problem);

}  // namespace packmesh::hemocell
