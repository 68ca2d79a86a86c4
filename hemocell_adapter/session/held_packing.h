// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Packings that are kept in memory instead of being written, for callers in other languages.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/session/session.h"
#include "hemocell_adapter/settings/request.h"
#include "packMesh/packing/packing_file.h"
#include "packMesh/packing/state_cells.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// A certified packing. Each rank has its share of the cells.
struct HeldPacking {
  std::vector<StateCells::Kind> kinds;  ///< of the species; their numbers are those of all ranks
  /// Without a problem after loading; see completed(). The species of its result are those of the problem or,
  /// without one, the kinds.
  Packing packing;
  std::vector<int> kindOf;  ///< by species of the result: index into `kinds`
  /// Without a problem: of this rank's cells that have meshes of their own, by index: vertices in the frame
  /// of the template [µm].
  std::map<std::size_t, std::vector<Vec3>> own;
  Communicator ranks;
  Box box;                               ///< of the lumen [µm]
  Vec3 period = Vec3::Zero();            ///< 0: not periodic [µm]
  std::shared_ptr<const Request> asked;  ///< nullptr: its state does not say
  std::filesystem::path file;            ///< from which it was loaded; empty if it was packed
  OutputRequest output;                  ///< with a problem: what its request writes
};

/// Packs as the program does, and writes nothing but the state and the states of the engine that the command
/// asks for.
/// @throws AgreedFailure (code `interrupted` if a hook asked for it), InputError. All ranks call
HeldPacking packInMemory(const Request& asked, const Communicator& ranks, const Hooks& hooks);

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
/// @param original where the file was when the packing was loaded from it first; empty: there
HeldPacking loadPacking(const std::filesystem::path& file, const Communicator& ranks,
                        const std::filesystem::path& original = {});

/// A loaded packing with its problem, which is built from its command, and with the certificate of its cells
/// in it. All ranks call. Pre: no problem
/// @throws AgreedFailure, InputError if the files that the command names are missing, or are others
HeldPacking completed(HeldPacking held);

/// Vertices of a cell that has a mesh of its own, in the frame of the template [µm]; nullptr: it has that.
const std::vector<Vec3>* ownVertices(const HeldPacking& held, std::size_t cell);

/// The numbers that are written to .pos files for this rank's cells, in their order.
std::vector<PosLine> posLinesOf(const HeldPacking& held);

/// Writes .pos files, all or none. All ranks call. Pre: with a problem
/// @param others that the caller will write, too
std::vector<std::filesystem::path> writeCells(const HeldPacking& held, const std::filesystem::path& folder,
                                              const std::vector<std::filesystem::path>& others);

/// Writes what the Python package needs to show and to convert the packing. All ranks call. Pre: with a
/// problem
void saveTables(const HeldPacking& held, const std::filesystem::path& file);

/// Writes .pos files of any cells, all or none. @throws OutputError
void writePosFiles(const std::filesystem::path& folder,
                   const std::vector<std::pair<std::string, std::vector<PosLine>>>& cells);

/// Writes a state file of cells that are as they are. One rank calls. @throws OutputError
/// @param state its cells all have vertices, and are sorted by kind and numbered
void saveCells(StateCells state, std::shared_ptr<const Container> lumen, const std::filesystem::path& file);

/// Writes a state file, from which the program continues and loadPacking() reads. All ranks call. Pre: packed
void savePacking(const HeldPacking& held, const std::filesystem::path& file);

/// The cells of all ranks with their meshes. All ranks call.
StateCells stateCellsOf(const HeldPacking& held);

/// What is measured of this rank's cells, in their order. All ranks call. Pre: with a problem
std::vector<CellColumn> columnsOf(const HeldPacking& held);

/// The report as JSON. All ranks call. Pre: with a problem
std::string reportOf(const HeldPacking& held);

}  // namespace packmesh::hemocell
