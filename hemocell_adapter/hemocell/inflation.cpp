// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/inflation.h"

namespace packmesh::hemocell {

void inflate(TriangleMesh& mesh, double distance) {
  std::vector<std::vector<int>> faces(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int v : mesh.triangles[t]) faces[v].push_back(static_cast<int>(t));
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    Vec3 sum = Vec3::Zero();
    for (int t : faces[v]) {
      const Vec3& a = mesh.corner(t, 0);
      sum += (mesh.corner(t, 1) - a).cross(mesh.corner(t, 2) - a).normalized();
    }
    mesh.vertices[v] += distance * sum.normalized();
  }
}

}  // namespace packmesh::hemocell
