// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The companion of a state file with which ParaView opens it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/packing/packing_problem.h"

namespace packmesh {

/// Writes an XDMF file that describes `stateFile` (of which the name alone is used: both belong into one
/// folder): all cells as points, with their number, species, orientation, scale, overlap, gap and local
/// hematocrit, and every species' template mesh, which ParaView's 3D glyphs put at the points. So a mesh is
/// there only once, however many cells there are. One rank calls it.
/// @param cells in the file
/// @throws OutputError when the file cannot be written
void writeXdmf(const std::filesystem::path& file, const std::filesystem::path& stateFile, std::int64_t cells,
               const std::vector<Species>& species);

}  // namespace packmesh
