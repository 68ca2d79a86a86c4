// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Meshes of soft cells for tests.
#pragma once

#include <cmath>
#include <map>
#include <random>
#include <utility>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh::sample {

/// A sphere whose triangles are nearly equilateral: an icosahedron, each triangle divided into four, `times`
/// times.
inline TriangleMesh roundSphere(int times, double radius = 1.0) {
  const double t = 0.5 * (1.0 + std::sqrt(5.0));
  TriangleMesh mesh;
  mesh.vertices = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                   {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int n = 0; n < times; ++n) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [at, isNew] = middles.insert({std::minmax(a, b), int(mesh.vertices.size())});
      if (isNew)
        mesh.vertices.push_back(0.5 * (mesh.vertices[a].normalized() + mesh.vertices[b].normalized()));
      return at->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const int d = middle(a, b), e = middle(b, c), f = middle(c, a);
      finer.insert(finer.end(), {{d, e, f}, {a, d, f}, {d, b, e}, {f, e, c}});
    }
    mesh.triangles = finer;
  }
  for (Vec3& v : mesh.vertices) v = radius * v.normalized();
  return mesh;
}

/// The shape of red cells as HemoCell makes it of a sphere, the axis along y [µm].
inline TriangleMesh redCell(int times, double radius = 3.91) {
  TriangleMesh mesh = roundSphere(times);
  for (Vec3& v : mesh.vertices) {
    const double r2 = std::min(1.0, v.x() * v.x() + v.z() * v.z());
    const double height = std::sqrt(1.0 - r2) * (0.054322 + 1.001279 * r2 - 0.561381 * r2 * r2);
    v = radius * Vec3(v.x(), std::copysign(height, v.y()), v.z());
  }
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
