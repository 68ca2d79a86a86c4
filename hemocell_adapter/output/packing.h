// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The cells of a problem, and what is known of them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/problem/problem.h"
#include "hemocell_adapter/settings/request.h"
#include "packMesh/packing/packing_file.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Times of a run [s].
struct RunTimes {
  double cpu = 0.0, wall = 0.0;
};

/// The angles of the .pos lines of cells, by which states give the rotations that were certified.
CellColumn angleColumn(const std::vector<BodyState>& cells, const ReadLines& read);

/// What HemoCell keeps of the cells of all ranks.
struct Kept {
  Loading loading = Loading::posFiles;
  std::vector<std::int64_t> kept;  ///< per species
  std::vector<double> excess;      ///< of these cells, see excessVolumes() [µm³]
  /// Why the others are deleted, in the order in which that occurs, with their number.
  std::vector<std::pair<std::string, std::int64_t>> reasons;
  struct Dropped {
    std::int64_t cell;
    std::int64_t reason;  ///< index into `reasons`
  };
  std::vector<Dropped> dropped;  ///< the others, ascending

  /// Whether the others do nothing but cross a periodic face.
  bool asExpected() const {
    return std::all_of(reasons.begin(), reasons.end(), [](const auto& one) { return isExpected(one.first); });
  }
  /// Whether it keeps a cell, given its number.
  bool keeps(std::int64_t cell) const {
    const auto at =
        std::lower_bound(dropped.begin(), dropped.end(), cell,
                         [](const Dropped& one, std::int64_t number) { return one.cell < number; });
    return at == dropped.end() || at->cell != cell;
  }
};

/// How much cells are deformed that have meshes of their own.
struct DeformedCells {
  std::int64_t cells = 0;
  Deformation most;    ///< the largest of each
  Deformation median;  ///< of each over these cells
};
/// Those of a packing: all, and of each species that has some.
struct Deformations : DeformedCells {
  std::vector<std::pair<std::string, DeformedCells>> species;
};

/// Cells that were packed, continued, loaded or read to be checked, certified and counted, of which each rank
/// has its share, in their problem. They are named by its species. Of cells that were loaded or read there
/// are neither counts of parts nor statistics.
struct Packing : PackingResult {
  Packing() = default;
  explicit Packing(PackingResult result) : PackingResult(std::move(result)) {}

  std::shared_ptr<const Problem> problem;
  OutputRequest output;  ///< what is written of it
  PartsToPack packed;    ///< with the clearances that were kept; of a check those demanded, and no parts
  std::vector<std::int64_t> partCounts;  ///< of all ranks; empty if nothing was packed
  Tally tally;                           ///< of all ranks
  Kept kept;
  RunTimes times;
  std::string whyFewer =
      {};                  ///< why cells could not be deformed as needed, if there are fewer than requested
  std::string raise = {};  ///< of fewer than requested: the option with which a restart may get farther
  bool checked = false;    ///< cells of files or states, as they are
  std::optional<Deformations> deformations = {};  ///< of all ranks, if there are deformed cells
  /// If the request asks for a state file: to be written with the cells.
  std::optional<PackingState> state = {};
  /// Of a packing that was repeated in a larger box: the one before.
  std::shared_ptr<const Packing> before = {};

  const Communicator& ranks() const { return problem->ranks; }
};

/// Of all ranks, of the cells that have meshes of their own; nothing if there are none, or none whose
/// membrane HemoCell's laws can be applied to. All ranks call.
std::optional<Deformations> deformationsOf(const Packing& packing);

/// The same of each of these cells, which are of one rank: columns `force` [pN], and `volume_change`,
/// `area_change`, `triangle_change`, `edge_change` [fraction]. 0 of a cell with the mesh of the template. No
/// columns if the problem has no meshes but templates.
std::vector<CellColumn> deformationColumns(const Problem& problem, const std::vector<PlacedCell>& cells);

/// Of the cells of a state.
std::vector<CellColumn> deformationColumns(const Problem& problem, const PartsToPack& packed,
                                           const std::vector<BodyState>& cells);

}  // namespace packmesh::hemocell
