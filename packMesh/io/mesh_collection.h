// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Several named meshes in one file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/io/named_mesh.h"

namespace packmesh {

/// @throws InputError when the ending is none that writeMeshes() knows
void requireMeshCollectionEnding(const std::filesystem::path& file);

/// Writes all meshes to one file, with coordinates [µm] that read back exactly. The kind follows the ending:
/// - .obj: one object (`o name`) per mesh;
/// - .ply: text; each triangle has the number of its mesh, from 0 on, as the property `part`, and comments
/// tell the names;
/// - .h5: HDF5, one group /meshes/<number> per mesh, with `vertices` (n x 3 doubles), `triangles` (m x 3
/// integers
///   from 0 on, counter-clockwise seen from outside) and the attribute `name`; the file's attribute `unit` is
///   "µm".
/// Line breaks in names become spaces.
/// @throws InputError when the ending is another one, OutputError when the file cannot be written
void writeMeshes(const std::filesystem::path& file, const std::vector<NamedMesh>& meshes);

}  // namespace packmesh
