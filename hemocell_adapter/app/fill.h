// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Packing for a running HemoCell, which receives the cells itself.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/running_case.h"
#include "packMesh/core/pose.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// A cell to be added.
struct AddedCell {
  std::int32_t type = 0;  ///< index into RunningCase::cells
  /// As HemoCell numbers the cells of .pos files: by type, then in the order of the file, from 0.
  std::int64_t id = 0;
  Placement placement;  ///< of the template, node (0, 0, 0) of the lattice at the origin [µm]
};

struct Filling {
  std::vector<std::int64_t> counts;  ///< of each type, on all ranks
  std::vector<AddedCell> cells;      ///< this rank's share
};

/// Packs cells into the fluid nodes of a running HemoCell, as the program packs a case: reports, states and other files
/// that `words` or `<packing>` ask for are written. .pos files are not, except to a stated output folder.
/// @param words options of the command line
/// @throws AgreedFailure, InputError, OutputError. Nothing is interrupted by signals. All ranks call
Filling fill(std::shared_ptr<const RunningCase> running, const std::vector<std::string>& words, const Communicator& ranks);

}  // namespace packmesh::hemocell
