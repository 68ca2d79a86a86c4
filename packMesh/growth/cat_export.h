// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file CAT cells as files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/growth/cat_cells.h"

namespace packmesh {

/// Writes every cell under the name of its object and, if there is one, the layer along the wall as "wall
/// layer".
/// @param names per object; objects without a name are called "cell 0", "cell 1" ...
/// @throws InputError see writeMeshes(): .obj, .ply, .h5
void writeCatCells(const std::filesystem::path& file, const CatCells& cells,
                   const std::vector<std::string>& names = {});

}  // namespace packmesh
