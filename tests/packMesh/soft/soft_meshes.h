// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Meshes of soft cells for tests.
#pragma once

#include "tests/packMesh/mesh/test_meshes.h"

namespace packmesh::sample {

/// A red cell with its axis along y [µm].
inline TriangleMesh redCell(int levels) {
  TriangleMesh mesh = test::redCell(levels);
  for (Vec3& v : mesh.vertices) v = Vec3(v.y(), v.z(), v.x());
  return mesh;
}

/// Every vertex displaced by up to `most` along each axis.
inline std::vector<Vec3> shaken(std::vector<Vec3> vertices, double most, unsigned seed) {
  std::mt19937 random(seed);
  for (Vec3& v : vertices)
    for (int k = 0; k < 3; ++k) v[k] += most * (2.0 * double(random()) / double(random.max()) - 1.0);
  return vertices;
}

}  // namespace packmesh::sample
