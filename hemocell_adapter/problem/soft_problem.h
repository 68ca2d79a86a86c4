// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cells that deform where undeformed ones cannot be packed.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/problem.h"
#include "packMesh/soft/soft_packing.h"

namespace packmesh::hemocell {

/// What packing soft cells asks and tells while it runs; the same on all ranks unless stated otherwise.
struct SoftRun {
  std::function<bool()> interrupted;                   ///< of this rank
  std::function<void(const Progress&)> progress = {};  ///< of this rank
  std::function<double()> elapsed;                     ///< of the time limit [s]
  /// Called with what is to be packed next, which stays where it is: adds checkpoints, and the state to
  /// continue from. @param last there are no smaller clearances
  /// @return false: the state is of smaller clearances
  std::function<bool(PackingProblem&, bool last)> prepare;
  bool deform = false;  ///< even where undeformed cells seem to be packed easily
};

struct SoftProblem {
  /// Of packing the cells where they are; nothing if they could not be packed, or that was interrupted.
  std::optional<Problem> problem;
  bool fewer = false;   ///< it has fewer cells than requested (--best-effort)
  std::string failure;  ///< why not all could be packed: "the cells had grown to 0.91 of their size"
  Notices notices;
  /// What was packed last, unless no cell is deformed; its state if all cells could be packed and states are
  /// saved.
  std::shared_ptr<const PackingProblem> packing;
  std::optional<PackingState> end;
};

/// Packs the cells of a problem, which may deform (packMesh/soft/soft_packing.h). All ranks call. If
/// undeformed cells can be packed easily, the problem is the same one.
SoftProblem packSoftProblem(const Problem& problem, const SoftRun& run);

}  // namespace packmesh::hemocell
