// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Output of a run besides the cells.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "hemocell_adapter/output/packing.h"
#include "packMesh/analysis/cell_measures.h"
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

// The program writes the packing as tables beside its outputs, has packmesh read them,
// and removes them. Where packmesh cannot be used, it says so before packing, and keeps them: the packing
// does not fail for that.

/// The files that packmesh will write; the tables if it cannot be used, of which it warns. One rank calls it.
/// @param counts of the species, at most
/// @throws InputError if another program cannot have these cells, or not there
std::vector<std::filesystem::path> convertedFiles(const Problem& problem, const OutputRequest& output,
                                                  const std::vector<std::int64_t>& counts);

/// Has them written, and prints their names. All ranks call. @throws AgreedFailure
void convert(const Packing& packing, const CellMeasures& measures);

/// The measurements of this rank's cells. All ranks call.
CellMeasures measuresOf(const Packing& packing);

/// The report (report.h) as JSON, which is not written. All ranks call.
std::string reportText(const Packing& packing);

/// Writes what the Python package needs to show and to convert the packing. All ranks
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

/// Writes the additional output that is requested: reports, and what the Python package makes;
/// prints their names. All ranks call. @throws AgreedFailure
void writeViews(const Packing& packing);

/// Whether all cells of a check were examined. Otherwise so many overlap that nothing else is written, which
/// a warning says.
bool isShowable(const Packing& checked);

}  // namespace packmesh::hemocell
