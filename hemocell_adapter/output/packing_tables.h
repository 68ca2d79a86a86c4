// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What the Python package needs of a packing to show and to convert it.
#pragma once

#include <cstdint>
#include <vector>

#include "hemocell_adapter/output/packing.h"
#include "packMesh/packing/packing_file.h"

namespace packmesh::hemocell {

/// The species and the lumen of a problem, without cells. One rank can call it. References the problem.
/// @param counts of the species, all ranks together
/// @throws InputError if a mesh file cannot be read any more
PackingTables emptyTables(const Problem& problem, const std::vector<std::int64_t>& counts);

/// The same with cells and faults: position and `angles` [degrees] as written to .pos files, and measures.
/// References `packing`. All ranks call. @throws AgreedFailure
PackingTables tablesOf(const Packing& packing, const CellMeasures& measures);

}  // namespace packmesh::hemocell
