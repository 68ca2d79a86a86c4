// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cells that deform where undeformed ones cannot be packed.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/problem.h"
#include "packMesh/soft/soft_packing.h"

namespace packmesh::hemocell {

struct SoftProblem {
  /// Of packing the cells where they are; nothing if they could not be packed, or that was interrupted.
  std::optional<Problem> problem;
  bool fewer = false;   ///< it has fewer cells than requested (--best-effort)
  std::string failure;  ///< why not all could be packed: "the cells had grown to 0.91 of their size"
  Notices notices;
};

/// Packs the cells of a problem, which may deform (packMesh/soft/soft_packing.h). All ranks call. If
/// undeformed cells can be packed easily, the problem is the same one.
/// @param elapsed of the time limit, the same on all ranks [s]
SoftProblem packSoftProblem(const Problem& problem, const std::function<bool()>& interrupted,
                            const std::function<void(const Progress&)>& progress,
                            const std::function<double()>& elapsed);

}  // namespace packmesh::hemocell
