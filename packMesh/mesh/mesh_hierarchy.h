// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A bounding hierarchy over the triangles of a mesh.
#pragma once

#include <memory>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

struct MeshTree;

/// A bounding hierarchy over the triangles of one template mesh, in its body frame; shared by all cells of a
/// species. Bounding volumes are conservative: triangles that meet are never culled.
class MeshHierarchy {
 public:
  /// @throws MeshError if the mesh has no triangles
  explicit MeshHierarchy(const TriangleMesh& mesh);
  /// Of a deformed form of another mesh: made in a tenth of the time, and somewhat slower to use.
  /// @param vertices in the order of the other mesh [µm]
  MeshHierarchy(std::vector<Vec3> vertices, const MeshHierarchy& undeformed);
  ~MeshHierarchy();
  MeshHierarchy(MeshHierarchy&&) noexcept;
  MeshHierarchy& operator=(MeshHierarchy&&) noexcept;

  const TriangleMesh& mesh() const;
  const MeshTree& tree() const { return *tree_; }  ///< see mesh_tree.h

 private:
  std::unique_ptr<const MeshTree> tree_;
};

/// A mesh and its placement in the world. References only.
struct PlacedHierarchy {
  const MeshHierarchy& hierarchy;
  const Placement& placement;

  std::size_t vertexCount() const { return hierarchy.mesh().vertices.size(); }
  Vec3 vertex(std::size_t i) const { return placement(hierarchy.mesh().vertices[i]); }
};

}  // namespace packmesh
