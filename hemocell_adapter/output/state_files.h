// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file State files: checkpoints, written at intervals, on a signal and when a run fails, and read by a
/// restart; the state of the result, which replaces an older one together with the cells of the run.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "hemocell_adapter/output/packing.h"
#include "hemocell_adapter/settings/request.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/state_file.h"

namespace packmesh::hemocell {

/// What a state says of a request: JSON (request_json.h) without --restart, and the numbers that were given.
/// Absolute paths of files in its folder become {"beside": relative path}, names that are not UTF-8 {"bytes":
/// [...]}.
StateRecord recordOf(const Request& request, const std::filesystem::path& state);

/// The request of a state, with the folder in which it is now.
/// @throws InputError if the state has none: it has the cells of a simulation, or is of version 2
Request requestIn(const StateRecord& record, const std::filesystem::path& state);

/// What is asked for or, if that is only a restart without a lumen, the request of the state, overridden by
/// the rest of it. Any rank calls it on its own. @throws UsageError, InputError
Request continued(const Request& asked);

/// Tests before hours of packing. @throws OutputError if its folder is not writable, or the state file (or
/// its checkpoint) exists and is not a state that may be replaced, or has the name of another output. Nothing
///   if no state is requested
void requireReplaceableState(const Request& request, const OutputRequest& output);

/// Saves the checkpoints of a run, and keeps the state of its result.
class StateFiles {
 public:
  /// References its arguments, which must outlive it.
  /// @param isContinued whether a run continues from states before its end; otherwise they are not saved
  /// @param savesFailed whether also from that of a packing that did not succeed
  StateFiles(const Request& request, const OutputRequest& output, const PackingProblem& problem,
             bool isContinued = true, bool savesFailed = true)
      : request_(request),
        output_(output),
        problem_(problem),
        isContinued_(isContinued),
        savesFailed_(savesFailed) {}
  StateFiles(const StateFiles&) = delete;
  StateFiles& operator=(const StateFiles&) = delete;

  /// Nothing if no state is requested.
  std::optional<Checkpoints> checkpoints();
  /// Whether the last checkpoint has been written; empty if none was due.
  std::optional<bool> saved() const { return saved_; }
  /// Whether one has been written.
  bool savedAny() const { return savedAny_; }
  /// The state of the result; empty if there is none.
  std::optional<PackingState>& end() { return end_; }

 private:
  void save(const PackingState& state);

  const Request& request_;
  const OutputRequest& output_;
  const PackingProblem& problem_;
  const bool isContinued_, savesFailed_;
  std::optional<bool> saved_;
  bool savedAny_ = false;
  std::optional<PackingState> end_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// The state file of a result, to be committed together with the cells (preparedState()). All ranks call.
/// Pre: the packing has a state
/// @throws OutputError on all ranks
std::unique_ptr<AtomicFiles> preparedResult(const Packing& packing, const std::filesystem::path& file,
                                            const FilesOfState& together);

/// Writes the state of a result of which no cells are written, or in place of the last checkpoint. All ranks
/// call. Pre: it has one, and a state is requested. @return false, with a warning, if that fails
bool saveResult(const Packing& packing);
bool saveAsCheckpoint(const Packing& packing);

/// Makes the folder of the state, if one is requested. All ranks call.
void makeStateFolder(const OutputRequest& output, const Communicator& ranks);

/// The checkpoint of a run that is to write a state. Pre: a state is requested
std::filesystem::path checkpointFile(const OutputRequest& output);

/// Removes the checkpoint of a run that has ended with a result. One rank calls. Pre: a state is requested
/// @param own whether the run has saved one
void removeCheckpoint(const Request& request, const OutputRequest& output, bool own);

/// The state from which a run continues. All ranks call. @throws InputError on all ranks
PackingState stateToContinue(const std::filesystem::path& file, const PackingProblem& problem);

}  // namespace packmesh::hemocell
