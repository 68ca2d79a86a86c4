// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The executable's commands: pack and check; and the lock that keeps two of them from one folder.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/settings/request.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// A lock that this process holds for the lifetime of the object; if the process ends in any other way, the
/// system releases it. It is a lock on a hidden file, which states the holder and is removed with it; a file
/// left by a killed process does no harm. It is visible to other machines with access to the folder. If the
/// file system does not support locks, there is none.
class RunLock {
 public:
  /// Locks a folder, which is created if necessary (and removed again if it stays empty).
  /// @throws OutputError if another process holds the lock
  static RunLock ofFolder(const std::filesystem::path& folder);
  /// Locks a file that will be written; its folder as above. Removes temporary files left by killed runs.
  /// @throws OutputError if another process holds the lock
  static RunLock ofFile(const std::filesystem::path& file);

  RunLock(RunLock&& other) noexcept;
  RunLock& operator=(RunLock&&) = delete;
  ~RunLock();

 private:
  RunLock() = default;
  void makeFolder(const std::filesystem::path& folder);
  void take(const std::filesystem::path& path, const std::filesystem::path& target, const char* kind,
            const char* advice);
  bool tryToTake(const std::filesystem::path& path);

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::vector<std::filesystem::path> made_ = {};  ///< folders made for the lock, outermost first
};

/// Packs, verifies and writes. Existing .pos files are replaced by certified ones or not at all. All ranks
/// call; the files written do not depend on the number of ranks.
/// @throws UsageError, InputError, OutputError; AgreedFailure if there are several ranks
ExitCode runPacking(const Request& asked, const Communicator& ranks);

/// Examines the .pos files of a folder, or those of each of several realisations: one line for each, and all
/// details of the folder that contains them. All ranks call; what is said and written does not depend on
/// their number.
/// @return ok if all are clean; otherwise the highest code
/// @throws UsageError, InputError; AgreedFailure if there are several ranks
ExitCode runCheck(const Request& asked, const Communicator& ranks);

/// All that the program does with its arguments: runs a command, prints what is asked for, reports errors.
/// All ranks call. Signals are caught from then on.
/// @return the exit code, the same on all ranks
ExitCode runAndTell(const std::string& program, const std::vector<std::string>& arguments,
                    const Communicator& ranks);

}  // namespace packmesh::hemocell
