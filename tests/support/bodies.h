// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Bodies of many forms, and a mixture of them in a vase.
#pragma once

#include <cmath>
#include <memory>
#include <random>

#include "packMesh/container/vessel.h"
#include "tests/support/cat.h"
#include "tests/support/packings.h"

namespace packmesh::test {

inline TriangleMesh tetrahedron() {
  TriangleMesh mesh;
  mesh.vertices = {{2, 2, 2}, {2, -2, -2}, {-2, 2, -2}, {-2, -2, 2}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  if (signedVolume(mesh) < 0.0) flip(mesh);
  return mesh;
}

inline TriangleMesh cube(double edge) {
  return sample::box(Vec3::Constant(-0.5 * edge), Vec3::Constant(0.5 * edge));
}

inline TriangleMesh cone() {
  constexpr int sides = 32;
  TriangleMesh mesh;
  for (int k = 0; k < sides; ++k) {
    const double angle = 2.0 * M_PI * k / sides;
    mesh.vertices.emplace_back(2.0 * std::cos(angle), 2.0 * std::sin(angle), -1.0);
  }
  mesh.vertices.emplace_back(0.0, 0.0, 3.0);
  mesh.vertices.emplace_back(0.0, 0.0, -1.0);
  for (int k = 0; k < sides; ++k) {
    mesh.triangles.push_back({k, (k + 1) % sides, sides});
    mesh.triangles.push_back({(k + 1) % sides, k, sides + 1});
  }
  return mesh;
}

/// A ball with twelve spikes as long as it is wide.
inline TriangleMesh star() {
  TriangleMesh mesh = icosphere(4);
  const std::vector<Vec3> spikes = icosphere(0).vertices;
  for (Vec3& v : mesh.vertices) {
    double most = 0.0;
    for (const Vec3& spike : spikes) most = std::max(most, std::exp(18.0 * (spike.dot(v) - 1.0)));
    v *= 1.0 + 2.2 * most;
  }
  return mesh;
}

/// Lobes and dents at random, about 3000 triangles.
inline TriangleMesh organic() {
  TriangleMesh mesh = sample::sphere(Vec3::Zero(), 1.0, 36, 44);
  std::mt19937 random(7);
  std::vector<Vec3> waves;
  for (int k = 0; k < 6; ++k) waves.push_back((2.6 + 0.8 * k) * randomDirection(random));
  for (Vec3& v : mesh.vertices) {
    double size = 2.4;
    for (std::size_t k = 0; k < waves.size(); ++k) size += 0.3 * std::sin(waves[k].dot(v) + double(k));
    v *= size;
  }
  return mesh;
}

/// A bent spindle, like a sickle cell.
inline TriangleMesh sickle() {
  return sample::tube(
      -3.5, 3.5, 17, 14, [](double x) { return Vec3(x, 0.12 * x * x - 0.5, 0.0); },
      [](double x) { return 0.15 + 0.95 * std::sqrt(std::max(0.0, 1.0 - x * x / 12.5)); });
}

/// A closed vase along x, 24 µm high: foot, belly, neck and rim.
inline std::shared_ptr<const Container> vase() {
  TriangleMesh mesh = sample::tube(
      0.0, 24.0, 25, 40, [](double x) { return Vec3(x, 0.0, 0.0); },
      [](double x) { return 7.0 + 2.5 * std::sin(0.30 * x - 0.5); });
  return makeVessel(std::move(mesh), {}, 0.25);
}

/// Spheres, cubes, cones, tori and sickles, `each` of each kind, to be grown.
inline PackingProblem mixtureIn(std::shared_ptr<const Container> container, std::int64_t each) {
  PackingProblem problem;
  const auto shape = [](const TriangleMesh& mesh) { return std::make_shared<const Shape>(mesh); };
  problem.physics.add("sphere", shape(icosphere(2, 1.8)), each);
  problem.physics.add("cube", shape(cube(2.8)), each);
  problem.physics.add("cone", shape(cone()), each);
  problem.physics.add("torus", shape(sample::torus(Vec3::Zero(), 2.0, 0.8, 20, 10)), each);
  problem.physics.add("sickle", shape(sickle()), each);
  problem.physics.container = std::move(container);
  useCat(problem);
  return problem;
}

}  // namespace packmesh::test
