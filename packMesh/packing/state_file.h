// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file States of packings in HDF5 files; docs/reference/state.md describes the format.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "packMesh/io/atomic_files.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_state.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh {

/// Names of files that were written together with a state, into the same folder, and hashes of their contents
/// (fileHash()).
using FilesOfState = std::map<std::string, std::string>;

/// Metadata of a state file.
struct StateHead {
  std::string digest;                ///< of the problem, see digestOf()
  std::vector<std::string> command;  ///< command line that started the run; its content is up to the caller
  std::string stage;                 ///< of the run, human-readable
  std::int64_t cells = 0;
  FilesOfState files;
};

/// Whether the cells of a state are those of a result: certified, and measured. All ranks call.
bool isFinished(const PackingState& state, const Communicator& ranks);

/// Writes `file` completely or not at all: under a temporary name in the same folder, flushed, then renamed.
/// The same state gives the same bytes on any number of ranks. All ranks call.
/// @throws OutputError on all ranks if that fails; an existing file of that name is then unchanged
void writeState(const std::filesystem::path& file, const PackingProblem& problem,
                const std::vector<std::string>& command, const PackingState& state);

/// The same file, complete under its temporary name, to be committed together with others. All ranks call.
/// @return of the first rank; of the others, something that has no files
/// @throws OutputError on all ranks
std::unique_ptr<AtomicFiles> preparedState(const std::filesystem::path& file, const PackingProblem& problem,
                                           const std::vector<std::string>& command, const PackingState& state,
                                           const FilesOfState& together = {});

/// Any rank may call it on its own. @throws InputError if the file is not a state file of this version
StateHead readStateHead(const std::filesystem::path& file);

/// The state with this rank's share of the cells. All ranks call.
/// @throws InputError on all ranks if the file is not a state file, is of another version, damaged, or not of
///   this problem
PackingState readState(const std::filesystem::path& file, const PackingProblem& problem);

}  // namespace packmesh
