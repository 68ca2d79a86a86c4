// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file One mesh in several levels of detail.
#pragma once

#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// One mesh in several levels of detail.
class LevelsOfDetail {
 public:
  /// Each level has a quarter of the vertices of the previous one, from unrefined() if possible, otherwise
  /// from decimated(); the coarsest one has at least 40 vertices, and none intersects itself.
  explicit LevelsOfDetail(const TriangleMesh& mesh);

  /// The level whose fraction of the vertices is nearest to `share`, as a ratio.
  const TriangleMesh& level(double share) const { return meshes_[indexOf(share)]; }
  int indexOf(double share) const;
  int count() const { return static_cast<int>(meshes_.size()); }
  const TriangleMesh& mesh(int index) const { return meshes_[index]; }

 private:
  std::vector<TriangleMesh> meshes_;  ///< the mesh itself first
};

}  // namespace packmesh
