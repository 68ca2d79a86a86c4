// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/cat_export.h"

#include "packMesh/io/mesh_collection.h"

namespace packmesh {

void writeCatCells(const std::filesystem::path& file, const CatCells& cells,
                   const std::vector<std::string>& names) {
  std::vector<NamedMesh> meshes;
  for (std::size_t i = 0; i < cells.cells.size(); ++i)
    meshes.push_back({i < names.size() ? names[i] : "cell " + std::to_string(i), cells.cells[i]});
  if (!cells.wallLayer.triangles.empty()) meshes.push_back({"wall layer", cells.wallLayer});
  writeMeshes(file, meshes);
}

}  // namespace packmesh
