// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Meshes and placements for tests.
#pragma once

#include <cmath>
#include <map>
#include <random>
#include <utility>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh::test {

/// Unit sphere: an icosahedron with every triangle split in four `levels` times; 642 vertices at level 3.
inline TriangleMesh icosphere(int levels, double radius = 1.0) {
  const double phi = (1.0 + std::sqrt(5.0)) / 2.0;
  TriangleMesh mesh;
  mesh.vertices = {{-1, phi, 0},  {1, phi, 0},  {-1, -phi, 0}, {1, -phi, 0}, {0, -1, phi},  {0, 1, phi},
                   {0, -1, -phi}, {0, 1, -phi}, {phi, 0, -1},  {phi, 0, 1},  {-phi, 0, -1}, {-phi, 0, 1}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto key = std::minmax(a, b);
      const auto [at, isNew] = middles.try_emplace(key, int(mesh.vertices.size()));
      if (isNew) mesh.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
      return at->second;
    };
    std::vector<Triangle> finer;
    for (const Triangle& t : mesh.triangles) {
      const int a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {t[1], b, a}, {t[2], c, b}, {a, b, c}});
    }
    mesh.triangles = finer;
    for (Vec3& v : mesh.vertices) v.normalize();
  }
  for (Vec3& v : mesh.vertices) v = radius * v.normalized();
  return mesh;
}

/// Biconcave red cell (Evans and Fung 1972), thin axis z.
inline TriangleMesh redCell(int levels = 3) {
  TriangleMesh mesh = icosphere(levels);
  const double r = 3.91;
  for (Vec3& v : mesh.vertices) {
    const double q = std::min(1.0, v.head<2>().squaredNorm());
    const double z = std::sqrt(1.0 - q) * (0.054322 + 1.001279 * q - 0.561381 * q * q);
    v = Vec3(r * v[0], r * v[1], std::copysign(r * z, v[2]));
  }
  return mesh;
}

template <class Random>
Vec3 randomDirection(Random& random) {
  std::normal_distribution<double> normal;
  const Vec3 v(normal(random), normal(random), normal(random));
  return v.normalized();
}

template <class Random>
Mat3 randomRotation(Random& random) {
  std::normal_distribution<double> normal;
  const double w = normal(random), x = normal(random), y = normal(random), z = normal(random);
  return Quaternion(w, x, y, z).normalized().toRotationMatrix();
}

}  // namespace packmesh::test
