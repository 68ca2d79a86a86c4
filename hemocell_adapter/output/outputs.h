// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Output of a run besides the cells: scenes, VTK files, reports.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hemocell_adapter/output/finished.h"
#include "packMesh/analysis/analysis_input.h"

namespace packmesh::hemocell {

/// For measuring cells, by the user's species, each of which may have had several parts.
AnalysisInput analysisInputOf(const Finished& done);

/// The report (report.h) as JSON, which is not written. All ranks call.
std::string reportText(const Finished& done, const RunTimes& times);

/// Fails before hours of packing rather than after them. One rank calls it.
/// @param withCells whether .pos files are written
/// @throws OutputError if a file or folder that will be written cannot be written, or was read
/// (InputRecord)
void requireWritableOutputs(const Problem& problem, const OutputRequest& output, bool withCells);
void requireWritable(const std::filesystem::path& folder);

/// What writeViews() writes, in the order of writing.
std::vector<std::filesystem::path> viewFiles(const Problem& problem, const OutputRequest& output);

/// Warns of .pos files that HemoCell would load together with the new ones.
void warnOfStaleFiles(const Problem& problem, const OutputRequest& output);

/// Writes the additional output that is requested: VTK files, reports; prints their
/// names. All ranks call. @throws AgreedFailure
void writeViews(const Finished& done, const RunTimes& times);

}  // namespace packmesh::hemocell
