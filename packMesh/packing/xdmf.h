// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The XDMF file with which ParaView opens a state file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/packing/packing_problem.h"

namespace packmesh {

/// Writes an XDMF file that describes `stateFile` (of which only the name is used: both have to be in the
/// same folder): all cells as points, with their id, species, orientation, scale, overlap, gap and local
/// hematocrit, and every species' template mesh, which ParaView's 3D glyphs draw at the points. A mesh is
/// therefore stored only once, however many cells there are. One rank calls it.
/// @param cells in the file
/// @throws OutputError if the file cannot be written
void writeXdmf(const std::filesystem::path& file, const std::filesystem::path& stateFile, std::int64_t cells,
               const std::vector<Species>& species);

}  // namespace packmesh
