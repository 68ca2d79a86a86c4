// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Construction of a job from the command line and the files it names.
#pragma once

#include <filesystem>
#include <optional>

#include "hemocell_adapter/problem/job.h"

namespace packmesh::hemocell {

/// Reads the files named on the command line (config.xml, <Cell>.xml, with `check` the list of .pos files)
/// and resolves defaults and overrides.
/// @param folderToCheck with `check`: the folder of the .pos files, regardless of other settings; without it,
///   a folder of realisations becomes a job with nothing but foldersToCheck
/// @param running inside HemoCell: the case, of which no file is read
/// @throws UsageError, InputError
Job makeJob(const CommandLine& commandLine, const std::optional<std::filesystem::path>& folderToCheck = {},
            std::shared_ptr<const RunningCase> running = nullptr);

}  // namespace packmesh::hemocell
