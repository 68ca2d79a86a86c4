// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What the Python package needs of a packing to show and to convert it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "hemocell_adapter/output/packing.h"
#include "packMesh/packing/packing_file.h"

namespace packmesh::hemocell {

/// Writes the species and the lumen of a problem, without cells, under a temporary name beside `file`. One
/// rank calls.
/// @param counts of the species, all ranks together
/// @throws InputError if a mesh file cannot be read any more; OutputError
std::unique_ptr<AtomicFiles> writtenWithoutCells(const std::filesystem::path& file, const Problem& problem,
                                                 const std::vector<std::int64_t>& counts);

/// The same with cells and faults: position and `angles` [degrees] as written to .pos files, and measures.
/// All ranks call.
/// @return on the first rank: to be ended and committed, or to be removed with the object
/// @throws AgreedFailure; OutputError on all ranks
std::unique_ptr<AtomicFiles> writtenTables(const std::filesystem::path& file, const Packing& packing,
                                           const CellMeasures& measures);

}  // namespace packmesh::hemocell
