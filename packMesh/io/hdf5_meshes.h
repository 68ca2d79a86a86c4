// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The HDF5 part of mesh_collection.h. Internal to packMesh/io.
#pragma once

#include <filesystem>
#include <vector>

#include "packMesh/io/named_mesh.h"

namespace packmesh {

/// @throws OutputError
void writeHdf5(const std::filesystem::path& file, const std::vector<NamedMesh>& meshes);

}  // namespace packmesh
