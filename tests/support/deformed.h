// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Deformed cells for tests.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh::test {

/// The vertices of a mesh, stretched and bent smoothly.
inline std::vector<Vec3> deformed(const TriangleMesh& mesh, int seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> within(-1.0, 1.0);
  const double stretch = 1.0 + 0.15 * within(random), bend = 0.05 * within(random),
               twist = 0.05 * within(random);
  std::vector<Vec3> vertices;
  for (const Vec3& v : mesh.vertices) {
    const double angle = twist * v.x();
    const double y = v.y() * std::cos(angle) - v.z() * std::sin(angle),
                 z = v.y() * std::sin(angle) + v.z() * std::cos(angle);
    vertices.emplace_back(stretch * v.x(), y + bend * v.x() * v.x(), z / stretch);
  }
  return vertices;
}

}  // namespace packmesh::test
