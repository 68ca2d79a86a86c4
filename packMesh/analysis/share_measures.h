// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Measures of the cells of a finished packing.
#pragma once

#include <vector>

#include "packMesh/analysis/cell_measures.h"

namespace packmesh {

/// measureCells() for cells that are shared out anyhow, as pack() gives them back: each rank gets what is
/// measured of those it brings. The numbers do not depend on the shares. All ranks call.
/// @param own full-size cells of this rank, after those of the ranks before
CellMeasures measureShare(const AnalysisInput& analysis, const std::vector<PlacedCell>& own);

}  // namespace packmesh
