// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Shapes for tests: HemoCell's cells, ellipsoids, meshes with and without a closed form.
#pragma once

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/cell_model.h"
#include "packMesh/shape/shape.h"
#include "tests/packMesh/mesh/test_meshes.h"
#include "tests/packMesh/sample_meshes.h"

namespace packmesh::test {

using ShapePointer = std::shared_ptr<const Shape>;

/// HemoCell's own cell of this name (RBC, PLT, WBC), on HemoCell's usual lattice.
inline ShapePointer hemocellShape(const std::string& name) {
  return hemocell::makeShape(*hemocell::defaultModel(name), 0.5);
}

inline ShapePointer redCellShape() {
  static const ShapePointer shape = hemocellShape("RBC");
  return shape;
}

inline ShapePointer sphereShape(double radius = 1.0) {
  return hemocell::makeEllipsoid(2.0 * radius, 2.0 * radius, 2.0 * radius);
}

/// A sheared and stretched sphere: convex, with no axis of symmetry.
inline TriangleMesh convexMesh(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> stretch(0.5, 2.5), shear(-0.5, 0.5);
  Mat3 map = Mat3::Identity();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) map(i, j) = i == j ? stretch(random) : shear(random);
  if (map.determinant() < 0.1) map = Mat3::diagonal({1.0, 0.6, 1.7});
  TriangleMesh mesh = icosphere(2);
  for (Vec3& v : mesh.vertices) v = map * v;
  return mesh;
}

/// A star-shaped body with bumps and dents.
inline TriangleMesh bumpyMesh(unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Vec3> waves;
  for (int k = 0; k < 3; ++k) waves.push_back(2.5 * randomDirection(random));
  TriangleMesh mesh = icosphere(3);
  for (Vec3& v : mesh.vertices) {
    double size = 2.0;
    for (const Vec3& wave : waves) size += 0.35 * std::sin(wave.dot(v) + 1.0);
    v *= size;
  }
  return mesh;
}

/// A thin rod bent to half a ring: its bounding box is mostly empty.
inline TriangleMesh hookMesh() {
  constexpr int count = 24, sides = 12;
  std::vector<std::vector<Vec3>> rings(count);
  for (int r = 0; r < count; ++r) {
    const double along = M_PI * r / (count - 1);
    const Vec3 out(std::cos(along), std::sin(along), 0.0);
    for (int k = 0; k < sides; ++k) {
      const double around = 2.0 * M_PI * k / sides;
      rings[r].push_back(3.0 * out + 0.5 * (std::cos(around) * out + std::sin(around) * Vec3::UnitZ()) -
                         Vec3(0.0, 1.5, 0.0));
    }
  }
  return sample::sweep(rings);
}

/// Sixteen points as a cluster that is never culled.
inline SamplePoints oneCluster(const std::vector<Vec3>& points) {
  SamplePoints one;
  one.clusters = 1;
  for (std::size_t k = 0; k < SamplePoints::width; ++k) {
    const Vec3& p = points[k % points.size()];
    one.x.push_back(float(p.x()));
    one.y.push_back(float(p.y()));
    one.z.push_back(float(p.z()));
  }
  one.centerX = one.centerY = one.centerZ = std::vector<float>(SamplePoints::width, 0.0f);
  one.radius.assign(SamplePoints::width, 1e3f);
  return one;
}

struct NamedShape {
  std::string name;
  ShapePointer shape;
};

/// Every kind of field: closed forms of revolution, one without, sampled ones.
inline const std::vector<NamedShape>& allShapes() {
  static const std::vector<NamedShape> shapes = {
      {"red cell", redCellShape()},
      {"platelet", hemocellShape("PLT")},
      {"white cell", hemocellShape("WBC")},
      {"ellipsoid", hemocell::makeEllipsoid(3.5, 6.0, 11.0)},
      {"convex mesh", std::make_shared<const Shape>(convexMesh(3))},
      {"bumpy mesh", std::make_shared<const Shape>(bumpyMesh(5))},
      {"hook", std::make_shared<const Shape>(hookMesh())},
  };
  return shapes;
}

}  // namespace packmesh::test
