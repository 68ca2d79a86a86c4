// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The executable's main job: pack and write.
#pragma once

#include <filesystem>
#include <functional>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/problem/job.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Packs, proves and writes what `job` says. Existing .pos files are replaced by certified ones or not at
/// all. All ranks call; what they write does not depend on how many there are.
/// @throws InputError, OutputError; AgreedFailure when there are several ranks
ExitCode runPacking(const Job& job, const Communicator& ranks);

/// Examines the .pos files of `job`.
/// @throws InputError
ExitCode runCheck(const Job& job);

/// Examines each of job.foldersToCheck and tells a line of it, of job.outputDirectory all. @param jobOf makes
/// the job of a folder
/// @return ok when all are clean; otherwise the highest code
ExitCode runCheckOfFolders(const Job& job, const std::function<Job(const std::filesystem::path&)>& jobOf);

}  // namespace packmesh::hemocell
