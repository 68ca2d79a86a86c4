// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The executable's main job: pack and write.
#pragma once

#include "hemocell_adapter/exit_codes.h"
#include "hemocell_adapter/job.h"

namespace packmesh::hemocell {

/// Packs, proves and writes what `job` says. Existing .pos files are replaced by certified ones or not at
/// all.
/// @throws InputError, OutputError
ExitCode runPacking(const Job& job);

/// Examines the .pos files of `job`.
/// @throws InputError
ExitCode runCheck(const Job& job);

}  // namespace packmesh::hemocell
