// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cells that deform where undeformed ones cannot be packed.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "hemocell_adapter/problem/problem.h"
#include "packMesh/soft/soft_packing.h"

namespace packmesh::hemocell {

/// What HemoCell starts with: the changes of the deformed cells, as lines of the summary.
std::vector<std::string> deformationLines(const std::vector<SoftlyPackedCell>& cells);

/// Packs the cells of a problem, which may deform (packMesh/soft/soft_packing.h). All ranks call.
/// @param lines about the deformations are appended
/// @return the problem of packing these cells, which are where they are to be; the same one if undeformed
/// cells can be
///   packed easily; nothing if the cells cannot be packed within the limits, or if that was interrupted
std::optional<Problem> softened(const Problem& problem, const std::function<bool()>& interrupted,
                                const std::function<void(const Progress&)>& progress,
                                std::vector<std::string>& lines);

}  // namespace packmesh::hemocell
