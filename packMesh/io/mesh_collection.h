// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Several named meshes in one file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/io/named_mesh.h"

namespace packmesh {

/// @throws InputError if writeMeshes() does not know the file extension
void requireMeshCollectionEnding(const std::filesystem::path& file);

/// Writes all meshes to one file, with coordinates [µm] that read back exactly. The extension determines the
/// format:
/// - .obj: one object (`o name`) per mesh;
/// - .ply: text; each triangle has the number of its mesh, from 0, as property `part`; comments contain the
/// names;
/// - .h5: HDF5, one group /meshes/<number> per mesh, with `vertices` (n x 3 doubles), `triangles` (m x 3
/// integers
/// from 0, counter-clockwise seen from outside) and the attribute `name`; the file's attribute `unit` is
/// "µm".
/// Line breaks in names are replaced by spaces.
/// @throws InputError for another extension, OutputError if the file cannot be written
void writeMeshes(const std::filesystem::path& file, const std::vector<NamedMesh>& meshes);

}  // namespace packmesh
