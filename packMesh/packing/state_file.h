// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file States of packings in HDF5 files; docs/reference/state.md describes the format.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_state.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh {

/// Metadata of a state file.
struct StateHead {
  std::string digest;                ///< of the problem, see digestOf()
  std::vector<std::string> command;  ///< command line that started the run; its content is up to the caller
  std::string stage;                 ///< of the run, human-readable
  std::int64_t cells = 0;
};

/// Writes `file` completely or not at all: under a temporary name in the same folder, flushed, then renamed.
/// The same state gives the same bytes on any number of ranks. All ranks call.
/// @throws OutputError on all ranks if that fails; an existing file of that name is then unchanged
void writeState(const std::filesystem::path& file, const PackingProblem& problem,
                const std::vector<std::string>& command, const PackingState& state);

/// Any rank may call it on its own. @throws InputError if the file is not a state file of this version
StateHead readStateHead(const std::filesystem::path& file);

/// The state with this rank's share of the cells. All ranks call.
/// @throws InputError on all ranks if the file is not a state file, is of another version, damaged, or not of
///   this problem
PackingState readState(const std::filesystem::path& file, const PackingProblem& problem);

}  // namespace packmesh
