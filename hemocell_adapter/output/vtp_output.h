// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Packings as plain VTK files.
#pragma once

#include <filesystem>
#include <vector>

#include "hemocell_adapter/output/finished.h"

namespace packmesh::hemocell {

/// The files that writeVtp() writes.
std::vector<std::filesystem::path> vtpFiles(const Problem& problem, const OutputRequest& output);

/// With --vtp (or --pov) `<Cell>.vtp`, a vertex for each cell with its measures, `<Cell>_mesh.vtp`, the mesh
/// to be drawn there, and `lumen.vtp`, the surface of the lumen or the edges of a box; with --vtp-meshes
/// `<Cell>_cells.vtp`, all membranes. All ranks call; the bytes do not depend on their number. @throws
/// AgreedFailure
void writeVtp(const Finished& done, const CellMeasures& measures);

}  // namespace packmesh::hemocell
