// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Several named meshes in one HDF5 file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// A mesh and its name.
struct NamedMesh {
  std::string name;
  TriangleMesh mesh;
  std::string kind = {};  ///< what it is, for the programs that read the file
};

/// Writes all meshes to one file: a group /meshes/<number> per mesh, with `vertices` (n x 3 doubles [µm]),
/// `triangles` (m x 3 integers from 0, counter-clockwise seen from outside) and the attributes `name` and
/// `kind`; the file's attribute `unit` is "µm".
/// @throws OutputError if the file cannot be written
void writeMeshes(const std::filesystem::path& file, const std::vector<NamedMesh>& meshes);

}  // namespace packmesh
