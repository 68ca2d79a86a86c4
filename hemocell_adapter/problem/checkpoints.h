// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Checkpoints: states of packings that are not finished, which stand beside the state of the result.
#pragma once

#include <filesystem>

#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

/// state.checkpoint.h5 of state.h5.
std::filesystem::path checkpointOf(const std::filesystem::path& state);

/// Whether a file has the name of a checkpoint.
bool isCheckpoint(const std::filesystem::path& file);

/// The state of the result of a run that continues from this file: state.h5 of state.checkpoint.h5, and of
/// state.h5.
std::filesystem::path resultOf(const std::filesystem::path& file);

/// Whether a run saves checkpoints. That deformed cells need a state file, which is written when all is done,
/// is no request for them.
bool savesCheckpoints(const Request& request);

}  // namespace packmesh::hemocell
