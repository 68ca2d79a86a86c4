// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Output of a run besides the cells.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hemocell_adapter/output/packing.h"
#include "packMesh/analysis/cell_measures.h"

namespace packmesh::hemocell {

/// The measurements of this rank's cells. All ranks call.
CellMeasures measuresOf(const Packing& packing);

/// The report (report.h) as JSON, which is not written. All ranks call.
std::string reportText(const Packing& packing);

/// Writes what the Python package needs to show and to convert the packing (packing_tables.h). All ranks
/// call.
/// @throws AgreedFailure, OutputError on all ranks
void saveTables(const Packing& packing, const std::filesystem::path& file);

/// Fails before hours of packing rather than after them. One rank calls it.
/// @param withCells whether .pos files are written
/// @param others that will be written, too
/// @throws OutputError if a file or folder that will be written cannot be written, or was read
/// (InputRecord)
void requireWritableOutputs(const Problem& problem, const OutputRequest& output, bool withCells,
                            const std::vector<std::filesystem::path>& others = {});
void requireWritable(const std::filesystem::path& folder);

/// Warns of .pos files that HemoCell would load together with the new ones.
void warnOfStaleFiles(const Problem& problem, const OutputRequest& output);

/// Writes the additional output that is requested: reports, and what the Python package makes
/// (conversions.h); prints their names. All ranks call. @throws AgreedFailure
void writeViews(const Packing& packing);

/// Whether all cells of a check were examined. Otherwise so many overlap that nothing else is written, which
/// a warning says.
bool isShowable(const Packing& checked);

}  // namespace packmesh::hemocell
