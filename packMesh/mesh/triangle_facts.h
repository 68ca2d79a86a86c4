// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Data of a triangle for the kernels that compute distances.
#pragma once

#include "packMesh/mesh/triangle_kernel.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

inline TriangleFacts factsOf(const TriangleMesh& mesh, int triangle) {
  TriangleFacts facts{};
  const Vec3 &a = mesh.corner(triangle, 0), &b = mesh.corner(triangle, 1), &c = mesh.corner(triangle, 2);
  const Vec3 normal = (b - a).cross(c - a).normalized();
  for (int e = 0; e < 3; ++e) {
    const Vec3& corner = mesh.corner(triangle, e);
    const Vec3 edge = mesh.corner(triangle, (e + 1) % 3) - corner, inward = normal.cross(edge);
    const double square = edge.squaredNorm();
    for (int k = 0; k < 3; ++k) {
      facts.corner[e][k] = static_cast<float>(corner[k]);
      facts.edge[e][k] = static_cast<float>(edge[k]);
      facts.inward[e][k] = static_cast<float>(inward[k]);
    }
    facts.perSquare[e] = square > 0.0 ? static_cast<float>(1.0 / square) : 0.0f;
    facts.normal[e] = static_cast<float>(normal[e]);
  }
  return facts;
}

}  // namespace packmesh
