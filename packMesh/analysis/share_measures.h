// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Measurements of the cells of a finished packing, for any distribution over ranks.
#pragma once

#include <vector>

#include "packMesh/analysis/cell_measures.h"

namespace packmesh {

/// measureCells() for cells distributed arbitrarily over the ranks, as pack() returns them: each rank gets
/// the measurements of its own cells. The numbers do not depend on the distribution. Collective.
/// @param own full-size cells of this rank; numbered globally in rank order
CellMeasures measureShare(const AnalysisInput& analysis, const std::vector<PlacedCell>& own);

}  // namespace packmesh
