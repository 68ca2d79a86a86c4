// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Outputs of cells of files.
#pragma once

#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/session/examination.h"

namespace packmesh::hemocell {

/// What HemoCell keeps of the cells of all ranks, and why it drops others.
Kept keptOf(const FoundCells& found, const Examination& examination);

/// Writes what is requested (reports, VTK files, exports) of examined cells, and prints the names of the
/// files. If too many cells overlap for an examination of all, a warning says that nothing is written. All
/// ranks call. Pre: the problem knows how many cells were found (readCells())
/// @throws OutputError; AgreedFailure if there are several ranks
void writeOutputsOf(const Problem& problem, const OutputRequest& output, const FoundCells& found,
                    const Examination& examination, const RunTimes& times);

}  // namespace packmesh::hemocell
