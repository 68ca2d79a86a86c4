// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The files for looking at and for other programs, which the Python package makes (command packmesh).
///
/// The program writes the packing as tables (packing_tables.h) beside its outputs, has packmesh read them,
/// and removes them. Where packmesh cannot be used, it says so before packing, and keeps them: the packing
/// does not fail for that.
#pragma once

#include <filesystem>
#include <vector>

#include "hemocell_adapter/output/packing.h"
#include "packMesh/analysis/cell_measures.h"

namespace packmesh::hemocell {

/// The files that packmesh will write; the tables if it cannot be used, of which it warns. One rank calls it.
/// @param counts of the species, at most
/// @throws InputError if another program cannot have these cells, or not there
std::vector<std::filesystem::path> convertedFiles(const Problem& problem, const OutputRequest& output,
                                                  const std::vector<std::int64_t>& counts);

/// Has them written, and prints their names. All ranks call. @throws AgreedFailure
void convert(const Packing& packing, const CellMeasures& measures);

}  // namespace packmesh::hemocell
