// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A job, from the command line and what it names.
#pragma once

#include <filesystem>
#include <optional>

#include "hemocell_adapter/problem/job.h"

namespace packmesh::hemocell {

/// Reads what the command line names (config.xml, <Cell>.xml, with `check` the list of .pos files) and
/// resolves defaults and overrides.
/// @param folderToCheck with `check`: the folder of the .pos files, whatever else says; without it, a folder
/// of
///   realisations becomes a job with nothing but foldersToCheck
/// @throws UsageError, InputError
Job makeJob(const CommandLine& commandLine, const std::optional<std::filesystem::path>& folderToCheck = {});

}  // namespace packmesh::hemocell
