// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What a run writes and where, with defaults and contradictions settled; output files to which all
/// ranks contribute.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/completed_request.h"
#include "hemocell_adapter/settings/request.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// The outputs of a packing. @throws UsageError
OutputRequest outputsToPack(const CompletedRequest& completed);
/// Without .pos files, unless their folder is stated: a running HemoCell gets the cells itself.
OutputRequest outputsInRunning(const CompletedRequest& completed);
/// Nothing but the state and the states of the engine that a front end asks for. What a `<packing>` section
/// of config.xml asks for is left to the program. @param asked by the front end
OutputRequest outputsInMemory(const Request& asked, const CompletedRequest& completed);

/// The outputs of a check, whose folder is that of the .pos files. What a configuration requests beside the
/// cells belongs to the run that packs them: a check writes what its front end requests.
/// @param asked by the front end @param folder regardless of other settings
OutputRequest outputsToCheck(const Request& asked, const CompletedRequest& completed,
                             const std::optional<std::filesystem::path>& folder = {});

/// What `check` examines if its folder has realisations: .pos files beside them, and each of them; else
/// nothing. @throws UsageError if outputs are requested, which are of one folder
std::vector<std::filesystem::path> foldersToCheck(const Request& request, const OutputRequest& output);

/// The folder of the outputs of a case.
std::filesystem::path outputFolder(const Case& simulation);

/// Which states of the engine are written: the first one and every so many after it.
struct FrameSeries {
  std::filesystem::path folder;  ///< of the outputs
  std::int64_t every = 0;
};
/// Nothing if none are requested.
std::optional<FrameSeries> requestedFrames(const OutputRequest& output);

// Checkpoints: states of packings that are not finished, which stand beside the state of the result.

/// state.checkpoint.h5 of state.h5.
std::filesystem::path checkpointOf(const std::filesystem::path& state);

/// Whether a file has the name of a checkpoint.
bool isCheckpoint(const std::filesystem::path& file);

/// The state of the result of a run that continues from this file: state.h5 of state.checkpoint.h5, and of
/// state.h5.
std::filesystem::path resultOf(const std::filesystem::path& file);

/// Whether a run saves checkpoints. That deformed cells need a state file, which is written when all is done,
/// is no request for them.
bool savesCheckpoints(const Request& request, const OutputRequest& output);

/// AtomicFiles of the first rank, to which the others send their parts. All ranks call everything.
/// @throws AgreedFailure on all ranks if something cannot be written
class SharedFiles {
 public:
  explicit SharedFiles(const Communicator& ranks) : ranks_(ranks) {}

  void makeFolder(const std::filesystem::path& folder);
  void begin(const std::filesystem::path& target);
  /// Adds the text of the first rank.
  void append(const std::function<std::string()>& text);
  /// Adds the texts of all ranks, in their order.
  void appendParts(const std::vector<std::string>& own);
  void end();
  /// See AtomicFiles. The first rank decides.
  void putAside(const std::filesystem::path& file, const std::filesystem::path& as) {
    files_.putAside(file, as);
  }
  void take(AtomicFiles& others);
  /// Of the file ended last (fileHash()).
  std::string hash();
  void commit();

 private:
  const Communicator& ranks_;
  AtomicFiles files_;  ///< of the first rank
};

}  // namespace packmesh::hemocell
