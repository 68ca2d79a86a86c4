// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/mesh_hierarchy.h"

#include <utility>

#include "packMesh/mesh/mesh_tree.h"

namespace packmesh {

MeshHierarchy::MeshHierarchy(const TriangleMesh& mesh) : tree_(std::make_unique<MeshTree>(mesh)) {}
MeshHierarchy::MeshHierarchy(std::vector<Vec3> vertices, const MeshHierarchy& undeformed)
    : tree_(std::make_unique<MeshTree>(std::move(vertices), undeformed.tree())) {}
MeshHierarchy::~MeshHierarchy() = default;
MeshHierarchy::MeshHierarchy(MeshHierarchy&&) noexcept = default;
MeshHierarchy& MeshHierarchy::operator=(MeshHierarchy&&) noexcept = default;

const TriangleMesh& MeshHierarchy::mesh() const {
  return tree_->mesh;
}

}  // namespace packmesh
