// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Packings that are kept in memory instead of being written, for callers in other languages.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/output/packing.h"
#include "hemocell_adapter/session/session.h"
#include "hemocell_adapter/settings/request.h"
#include "packMesh/packing/packing_file.h"
#include "packMesh/packing/state_file.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Packs as the program does, and writes nothing but the state and the states of the engine that the command
/// asks for.
/// @throws AgreedFailure (code `interrupted` if a hook asked for it), InputError. All ranks call
Packing packInMemory(const Request& asked, const Communicator& ranks, const Hooks& hooks);

/// A problem and what its request writes.
struct Prepared {
  std::shared_ptr<const Problem> problem;
  OutputRequest output;
};

/// Makes the problem that packInMemory() would pack. All ranks call.
/// @param interrupted polled meanwhile
/// @throws AgreedFailure, InputError
Prepared prepareInMemory(const Request& asked, const Communicator& ranks,
                         const std::function<bool()>& interrupted = {});

/// The cells of a state file of a finished packing. All ranks call. @throws InputError
/// @param original where the file was when the packing was loaded from it first
StateCells loadCells(const std::filesystem::path& file, const Communicator& ranks,
                     const std::filesystem::path& original);

/// What was asked for when cells were packed; nullptr: their state does not say. @param file of the state
std::shared_ptr<const Request> requestOfCells(const StateCells& cells, const std::filesystem::path& file);

/// The packing of loaded cells: their problem is made of their command, and they are certified in it. All
/// ranks call.
/// @throws AgreedFailure, InputError if the files that the command names are missing, or are others
Packing completePacking(const StateCells& cells, const std::filesystem::path& file,
                        const Communicator& ranks);

/// The species of a packing as kinds of cells, with their numbers on all ranks.
std::vector<StateCells::Kind> kindsOf(const Packing& packing);
/// Of each species of a problem: the kind with its name; -1: none.
std::vector<int> findKinds(const Problem& problem, const std::vector<StateCells::Kind>& kinds);

/// The numbers that are written to .pos files for this rank's cells, in their order.
std::vector<PosLine> posLinesOf(const Packing& packing);

/// Writes .pos files, all or none. All ranks call.
/// @param others that the caller will write, too
std::vector<std::filesystem::path> writeCells(const Packing& packing, const std::filesystem::path& folder,
                                              const std::vector<std::filesystem::path>& others);

/// Writes .pos files of any cells, all or none. @throws OutputError
void writePosFiles(const std::filesystem::path& folder,
                   const std::vector<std::pair<std::string, std::vector<PosLine>>>& cells);

/// Writes a state file of cells that are as they are. One rank calls. @throws OutputError
/// @param state its cells all have vertices, and are sorted by kind and numbered
void saveCells(StateCells state, std::shared_ptr<const Container> lumen, const std::filesystem::path& file);

/// Writes a state file, from which the program continues and loadCells() reads. All ranks call. Pre: packed,
/// not loaded
void savePacking(const Packing& packing, const std::filesystem::path& file);

/// The cells of a packing with the meshes of those that have their own, of this rank.
StateCells cellsOf(const Packing& packing, const std::vector<StateCells::Kind>& kinds);
/// The cells of all ranks. All ranks call.
StateCells gatherCells(const StateCells& own, const Communicator& ranks);

/// What is measured of this rank's cells, in their order. All ranks call.
std::vector<CellColumn> columnsOf(const Packing& packing);

}  // namespace packmesh::hemocell
