// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Scenes of arbitrary meshes for POV-Ray 3.7.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// A mesh and its appearance.
struct PictureMesh {
  const TriangleMesh* mesh;
  std::array<double, 3> color;  ///< red, green, blue, 0 to 1
  double transparency = 0.0;    ///< 0: opaque, 1: invisible
  bool edges = false;           ///< draw the edges between faces in different planes
};

/// Writes a scene of meshes in a container, which looks like glass; otherwise like writePovScene().
/// @throws OutputError if the file cannot be written; an existing file is then unchanged
void writePovMeshes(const std::filesystem::path& file, const std::vector<PictureMesh>& meshes,
                    const TriangleMesh& container);

}  // namespace packmesh
