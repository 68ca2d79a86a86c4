// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/shape/surface_distance.h"

#include "packMesh/mesh/closest_point.h"
#include "tests/support/catch.h"
#include "tests/support/shapes.h"

using namespace packmesh;

TEST_CASE("Distance, nearest point and bound of every kind of shape agree with the mesh") {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const auto& [name, shape] : test::allShapes()) {
    CAPTURE(name);
    const SurfaceDistance field(*shape);
    const ClosestPoint mesh(shape->mesh());
    // Facets are below the closed form by their sagitta (0.036 of the radius for the platelet of 66
    // vertices); a grid errs at edges.
    const double facets = 0.04 * shape->radius();
    for (int n = 0; n < 400; ++n) {
      const Triangle& t = shape->mesh().triangles[random() % shape->mesh().triangles.size()];
      const double u = unit(random), v = (1.0 - u) * unit(random);
      const Vec3 a = shape->mesh().vertices[t[0]], b = shape->mesh().vertices[t[1]],
                 c = shape->mesh().vertices[t[2]];
      const Vec3 p = a + u * (b - a) + v * (c - a) +
                     0.1 * shape->radius() * unit(random) * test::randomDirection(random);
      const double truth = mesh.signedDistance(p);
      const DistanceSample sample = field.sample(p);
      CHECK(sample.distance == Approx(truth).margin(facets));
      CHECK(sample.gradient.norm() == Approx(1.0));
      CHECK(field.lowerBound(p) <= truth + 1e-9);
      const Vec3 foot = field.foot(p, sample);
      // Of first order in the distance (up to 0.1 of the radius), which adds a little.
      CHECK(std::abs(mesh.signedDistance(foot)) < 1.1 * facets);
      CHECK((foot - p).norm() < std::abs(truth) + 2.0 * facets);
    }
  }
}

TEST_CASE("Far away, the nearest point is still on the surface") {
  std::mt19937 random(22);
  for (const auto& [name, shape] : test::allShapes()) {
    if (!std::holds_alternative<ProfileSurface>(shape->field())) continue;
    CAPTURE(name);
    const SurfaceDistance field(*shape);
    const ClosestPoint mesh(shape->mesh());
    for (int n = 0; n < 200; ++n) {
      const Vec3 p = 1.5 * shape->radius() * test::randomDirection(random);
      const DistanceSample sample = field.sample(p);
      const double truth = mesh.signedDistance(p);
      CHECK(sample.distance > 0.0);
      CHECK(sample.distance < 2.1 * truth);
      CHECK(field.lowerBound(p) <= truth + 1e-9);
      CHECK(std::abs(mesh.signedDistance(field.foot(p, sample))) < 0.1 * shape->radius());
    }
  }
}

TEST_CASE("The depth inside an ellipsoid does not depend on the order of the axes and is never too large") {
  std::mt19937 random(23);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto turned = [](const Vec3& v) { return Vec3(v.z(), v.x(), v.y()); };
  for (const Vec3& semiAxes : {Vec3(4.0, 1.5, 4.0), Vec3(1.5, 5.0, 1.5), Vec3(1.75, 3.3, 4.9)}) {
    CAPTURE(semiAxes);
    TriangleMesh mesh = test::icosphere(5);
    for (Vec3& v : mesh.vertices) v = v.cwiseProduct(semiAxes);
    const ClosestPoint surface(mesh);
    const auto shapeOf = [&](const Vec3& r) {
      return Shape(test::icosphere(1), ellipsoidProfile(r.x(), r.y(), r.z()));
    };
    const Shape shapes[] = {shapeOf(semiAxes), shapeOf(turned(semiAxes)), shapeOf(turned(turned(semiAxes)))};
    for (const Shape& shape : shapes) CHECK(shape.halfThickness() == Approx(semiAxes.minCoeff()));
    const SurfaceDistance first(shapes[0]), second(shapes[1]), third(shapes[2]);
    CHECK(first.sample(Vec3::Zero()).distance == Approx(-semiAxes.minCoeff()));
    for (int n = 0; n < 500; ++n) {
      const Vec3 p = 0.99 * unit(random) * test::randomDirection(random).cwiseProduct(semiAxes);
      const double depth = -first.sample(p).distance, truth = -surface.signedDistance(p);
      CHECK(-second.sample(turned(p)).distance == Approx(depth).epsilon(1e-9));
      CHECK(-third.sample(turned(turned(p))).distance == Approx(depth).epsilon(1e-9));
      CHECK(depth < truth + 0.003);  // facets
      CHECK(depth > 0.5 * truth);
    }
  }
}

TEST_CASE("The thickness of a mesh does not depend on its orientation in the file") {
  TriangleMesh mesh = test::redCellShape()->mesh();
  const double expected = test::redCellShape()->halfThickness();
  CHECK(expected == Approx(1.15).margin(0.01));
  const Quaternion turns[] = {Quaternion::Identity(), Quaternion(1.0, 1.0, 0.0, 0.0).normalized(),
                              Quaternion(1.0, 0.3, -0.7, 2.0).normalized()};
  for (const Quaternion& turn : turns) {
    TriangleMesh turned = mesh;
    for (Vec3& v : turned.vertices) v = turn * v;
    CHECK(Shape(turned).halfThickness() == Approx(expected).epsilon(0.08));
  }
}

TEST_CASE("A thin plate has the right thickness") {
  const Shape plate(sample::box({-4.0, -4.0, -0.02}, {4.0, 4.0, 0.02}));
  CHECK(plate.halfThickness() > 0.0);
  CHECK(plate.halfThickness() < 0.1);
}
