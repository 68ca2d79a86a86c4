// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The executable's main job: pack and write.
#pragma once

#include <filesystem>
#include <functional>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/problem/job.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Packs, verifies and writes `job`. Existing .pos files are replaced by certified ones or not at all. All
/// ranks call; the files written do not depend on the number of ranks.
/// @throws InputError, OutputError; AgreedFailure if there are several ranks
ExitCode runPacking(const Job& job, const Communicator& ranks);

/// Examines the .pos files of `job`. All ranks call; what is said and written does not depend on their
/// number.
/// @throws InputError; AgreedFailure if there are several ranks
ExitCode runCheck(const Job& job, const Communicator& ranks);

/// Examines each of job.foldersToCheck and prints one line for each, and all details of job.outputDirectory.
/// All ranks call.
/// @param jobOf creates the job of a folder
/// @return ok if all are clean; otherwise the highest code
ExitCode runCheckOfFolders(const Job& job, const Communicator& ranks,
                           const std::function<Job(const std::filesystem::path&)>& jobOf);

}  // namespace packmesh::hemocell
