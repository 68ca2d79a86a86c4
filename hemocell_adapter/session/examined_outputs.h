// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Outputs of cells of files.
#pragma once

#include <functional>

#include "hemocell_adapter/output/finished.h"
#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/session/examination.h"

namespace packmesh::hemocell {

/// What HemoCell keeps of the cells of all ranks, and why it drops others.
Kept keptOf(const FoundCells& found, const Examination& examination);

/// Calls use() with the examined cells, unless so many overlap that not all were examined: then a warning
/// says that nothing else is written. All ranks call. Pre: the problem knows how many cells were found
/// (readCells())
void withExamined(Problem problem, const OutputRequest& output, const FoundCells& found,
                  const Examination& examination, const std::function<void(const Finished&)>& use);

/// Writes what is requested (reports, VTK files, exports) of examined cells, and prints the names of the
/// files. See withExamined(). All ranks call.
/// @throws OutputError; AgreedFailure if there are several ranks
void writeOutputsOf(const Problem& problem, const OutputRequest& output, const FoundCells& found,
                    const Examination& examination, const RunTimes& times);

}  // namespace packmesh::hemocell
