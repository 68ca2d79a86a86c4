// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Pictures of any meshes: a scene for POV-Ray 3.7.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// A mesh and how it is shown.
struct PictureMesh {
  const TriangleMesh* mesh;
  std::array<double, 3> color;  ///< red, green, blue, 0 to 1
  double transparency = 0.0;    ///< 0: none, 1: not seen
  bool edges = false;           ///< draws the edges between faces that are not in one plane
};

/// Writes a scene of meshes in a container, which is shown like glass; else as writePovScene().
/// @throws OutputError when the file cannot be written; then an older file of that name is unchanged
void writePovMeshes(const std::filesystem::path& file, const std::vector<PictureMesh>& meshes,
                    const TriangleMesh& container);

}  // namespace packmesh
