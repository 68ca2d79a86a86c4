// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Outputs of cells of files.
#pragma once

#include "hemocell_adapter/app/examination.h"
#include "hemocell_adapter/output/summary.h"

namespace packmesh::hemocell {

/// Writes what the scene requests (reports, VTK files, exports) of examined cells, and prints the names of
/// the files. If too many cells overlap for an examination of all, a warning says that nothing is written.
/// @throws OutputError
void writeOutputsOf(Scene scene, const FoundCells& found, const Examination& examination,
                    const RunTimes& times);

}  // namespace packmesh::hemocell
