// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Packings for a running HemoCell, which receives the cells itself: what the plug-in calls.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/case.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/problem/physics.h"

namespace packmesh::hemocell {

/// Cells to be added, whose species are indices into RunningSystem::cells.
struct CellsToAdd {
  std::vector<std::int64_t> counts;  ///< of each type, on all ranks
  /// This rank's share, as HemoCell numbers the cells of .pos files: by type, then in the order of the file,
  /// from 0.
  std::vector<Cell> cells;
  /// Of each, by the numbers of .pos files: of its template, node (0, 0, 0) of the lattice at the origin
  /// [µm].
  std::vector<Placement> placements;
};

/// Packs cells into the fluid nodes of a running HemoCell, as the program packs a case: reports, states and
/// other files that the request or `<packing>` ask for are written. .pos files are not, except to a stated
/// output folder.
/// @throws AgreedFailure, InputError, OutputError. Nothing is interrupted by signals. All ranks call
CellsToAdd fill(std::shared_ptr<const Case> simulation, const Request& asked, const Communicator& ranks);

/// The cells of a state file. Those of a finished packing are read by each rank in part, and tested against
/// the fluid nodes, and so are cells that all have meshes of their own; unless they were certified in this
/// lumen, they are examined, too. Those that overlap, and others, are the start of a packing of the same
/// cells.
/// @param leavesOut cells that HemoCell would delete are left out, with a warning; otherwise they are an
/// error
/// @throws AgreedFailure, InputError. All ranks call
CellsToAdd fillFromState(std::shared_ptr<const Case> simulation, const std::filesystem::path& file,
                         bool leavesOut, const Communicator& ranks);

/// Writes the cells of a running simulation to a state file, numbered by type and then by their numbers in
/// HemoCell; either all of them have vertices that are kept, or none.
/// @param cells with the numbers of HemoCell; their species are indices into RunningSystem::cells
/// @param residual largest of their fits on this rank, root mean square over the vertices of a cell [µm]
/// @throws OutputError, AgreedFailure, InputError. All ranks call
void saveCells(std::shared_ptr<const Case> simulation, const std::vector<Cell>& cells, double residual,
               std::int64_t iteration, const std::filesystem::path& file, const Communicator& ranks);

}  // namespace packmesh::hemocell
