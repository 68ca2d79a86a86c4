// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file States of packings in HDF5 files; docs/reference/state.md describes the format.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

class Hdf5Reader;
class Hdf5Writer;

/// Names of files that were written together with a state, into the same folder, and hashes of their contents
/// (fileHash()).
using FilesOfState = std::map<std::string, std::string>;

/// Numbers that a state keeps for its caller.
struct StateTable {
  std::string name;
  int columns = 1;
  std::vector<double> values;  ///< row by row
};

/// Where the cells of a state are from; the contents are up to the caller.
struct StateRecord {
  std::string request;             ///< of a packing: what was asked for
  std::vector<StateTable> inputs;  ///< of it: what was given as numbers
  std::string origin;              ///< of cells that were not packed
};

/// Metadata of a state file.
struct StateHead {
  std::string digest;  ///< of the problem, see digestOf()
  StateRecord record;
  std::string stage;  ///< of the run, human-readable: that of an engine, finishedStage
  std::int64_t cells = 0;
  bool deformed = false;  ///< some have meshes of their own
  FilesOfState files;
};

/// The version that is written, and the oldest of which cells can be read.
constexpr std::int64_t stateVersion = 3, oldestStateVersion = 2;

/// The stage of a result.
inline constexpr const char* finishedStage = "finished";

/// Whether the cells of a state are those of a result: certified, and measured. All ranks call.
bool isFinished(const PackingState& state, const Communicator& ranks);

/// The state of a run that ended with these cells, with ids from 0 on: this rank's share. All ranks call.
/// @param own cells of this rank, in any order
/// @param vertices of each of these, see PackingState; empty on all ranks: none
PackingState finalState(std::vector<BodyState> own, const Communicator& ranks,
                        std::vector<std::vector<Vec3>> vertices = {});

/// Writes `file` completely or not at all: under a temporary name in the same folder, flushed, then renamed.
/// The same state gives the same bytes on any number of ranks. All ranks call.
/// @throws OutputError on all ranks if that fails; an existing file of that name is then unchanged
void writeState(const std::filesystem::path& file, const PackingProblem& problem, const StateRecord& record,
                const PackingState& state);

/// The same file, complete under its temporary name, to be committed together with others. All ranks call.
/// @return of the first rank; of the others, something that has no files
/// @throws OutputError on all ranks
std::unique_ptr<AtomicFiles> preparedState(const std::filesystem::path& file, const PackingProblem& problem,
                                           const StateRecord& record, const PackingState& state,
                                           const FilesOfState& together = {});

/// Any rank may call it on its own. Of version 2 no request is read: it was a command line.
/// @throws InputError if the file is not a state file of this version, or of one from `oldest` on
StateHead readStateHead(const std::filesystem::path& file, std::int64_t oldest = stateVersion);

/// Of a file that is known to be a state. Empty in one of version 2 with the cells of a packing.
StateRecord readStateRecord(const Hdf5Reader& in);

/// The state with this rank's share of the cells. All ranks call.
/// @throws InputError on all ranks if the file is not a state file, is of another version, damaged, or not of
///   this problem
PackingState readState(const std::filesystem::path& file, const PackingProblem& problem);

/// A group that states of all engines have, and those of none. An engine decides what its numbers are.
struct EngineTables {
  std::array<std::int64_t, 6> position = {};  ///< counters; the second is that of iterations
  std::array<double, 2> numbers = {};
  std::vector<double> taken;    ///< of each cell of this rank: share of its last step
  std::vector<BodyState> best;  ///< all cells in the best state of earlier attempts, or none

  /// All ranks call.
  void write(Hdf5Writer& out, const Physics& physics) const;
  /// Every rank calls it on its own. @param count of cells from the first one on; 0: without them
  /// @throws InputError if they are not those of a run, whose numbers are at least 0
  static EngineTables read(const Hdf5Reader& in, const PackingProblem& problem, std::int64_t first,
                           std::int64_t count);
};

/// Cells with their kinds, which Cell::species counts.
struct StateCells {
  /// A kind of cell. Parts of it that were packed under different constraints are one.
  struct Kind {
    std::string name;
    TriangleMesh mesh;       ///< the template [µm]
    std::int64_t count = 0;  ///< cells in the file
  };
  std::vector<Kind> species;
  Box box;                     ///< of the lumen [µm]
  Vec3 period = Vec3::Zero();  ///< 0: not periodic [µm]
  std::vector<Cell> cells;     ///< this rank's share, at full size, in the order of the file
  StateRecord record;
  bool certified = false;  ///< they are those of a finished packing
  bool deformed = false;   ///< some have meshes of their own
};

/// Reads the cells; every rank a part of its own. All ranks call.
/// @param withMeshes also the vertices of those that have meshes of their own
/// @throws InputError on all ranks if the file is not a state, of a version that is not read, damaged, or of
/// cells that still grow
StateCells readStateCells(const std::filesystem::path& file, const Communicator& ranks,
                          bool withMeshes = true);

}  // namespace packmesh
