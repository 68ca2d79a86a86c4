// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Packings on their way, in HDF5 files; docs/reference/state.md describes what is where.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_state.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh {

/// What a state file says besides the state.
struct StateHead {
  std::string digest;                ///< of the problem, see digestOf()
  std::vector<std::string> command;  ///< program and arguments that began the run; whatever the caller likes
  std::string stage;                 ///< of the run, for people
  std::int64_t cells = 0;
};

/// Writes `file` at once or not at all: under another name in the same folder, flushed, then renamed. The
/// same state gives the same bytes on any number of ranks. All ranks call.
/// @throws InputError on all ranks when that fails; what was there under the name before is still there then
void writeState(const std::filesystem::path& name, const PackingProblem& problem,
                const std::vector<std::string>& command, const PackingState& state);

/// Any rank may call it on its own. @throws InputError when the file is not a state file of this version
StateHead readStateHead(const std::filesystem::path& file);

/// The state with this rank's share of the cells. All ranks call.
/// @throws InputError when the file is foreign, of another version, damaged, or not of this problem; on all
/// ranks, each
PackingState readState(const std::filesystem::path& file, const PackingProblem& problem);

}  // namespace packmesh
