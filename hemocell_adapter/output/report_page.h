// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A report for readers: one HTML file with an interactive view.
#pragma once

#include <string>
#include <vector>

#include "hemocell_adapter/output/pictured_cell.h"
#include "hemocell_adapter/output/report.h"

namespace packmesh::hemocell {

/// False in a build of the plug-in alone (PACKMESH_PLUGIN_ONLY).
bool hasReportPage();

/// The page of a report. It loads no other files: style, scripts and libraries are part of it
/// (hemocell_adapter/output/page), and so are the report and what the view draws. One rank calls it.
/// Pre: hasReportPage().
/// @param cells of all ranks
std::string pageText(const Report& report, const Finished& done, const std::vector<PicturedCell>& cells);

/// What the view draws, as JSON whose arrays are numbers in base64 (docs/reference/report.md).
/// @param mostCells of more cells, a slice across the longest axis of the lumen is drawn
Report viewOf(const Finished& done, const std::vector<PicturedCell>& cells, std::size_t mostCells);

/// A mesh with at most about `mostTriangles`: vertices in the same cube of a grid are merged.
TriangleMesh coarsened(const TriangleMesh& mesh, std::size_t mostTriangles);

}  // namespace packmesh::hemocell
