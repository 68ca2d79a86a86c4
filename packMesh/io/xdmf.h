// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The companion of a state file with which ParaView opens it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/geometry/triangle_mesh.h"

namespace packmesh {

/// What a state file has of a species.
struct XdmfSpecies {
  std::string name;
  std::int64_t cells = 0;  ///< in the file's tables, after those of the species before
  std::int64_t vertices = 0, triangles = 0;
};

/// Writes an XDMF file that describes `stateFile` (of which the name alone is used: both belong into one
/// folder): for every species the cells as points, with their number, orientation (w, x, y, z), scale and
/// overlap, and the template mesh, which ParaView's 3D glyphs put at every point. So the mesh is there only
/// once, however many cells there are. One rank calls it. @throws InputError when the file cannot be written
void writeXdmf(const std::filesystem::path& file, const std::filesystem::path& stateFile,
               const std::vector<XdmfSpecies>& species);

}  // namespace packmesh
