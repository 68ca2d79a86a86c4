// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Measurements of the cells of a finished packing, for any distribution over ranks.
#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "packMesh/analysis/cell_measures.h"

namespace packmesh {

/// measureCells() for cells distributed arbitrarily over the ranks, as pack() returns them: each rank gets
/// the measurements of its own cells. The numbers do not depend on the distribution. Collective.
/// @param own full-size cells of this rank; numbered globally in rank order
/// @param outside cells that are not wholly inside the lumen, numbered over all ranks, the same on all:
/// local hematocrits leave them out. A certified packing has none
/// @param largestGap larger gaps are not measured [µm]
CellMeasures measureShare(const Physics& physics, const Execution& execution,
                          const std::vector<PlacedCell>& own, const std::set<std::int64_t>& outside = {},
                          double largestGap = usualGapOfInterest);

}  // namespace packmesh
