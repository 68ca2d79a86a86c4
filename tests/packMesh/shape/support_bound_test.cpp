// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/shape/support_bound.h"

#include <catch2/catch.hpp>
#include <random>

#include "tests/support/shapes.h"

using namespace packmesh;

namespace {

/// Whether `p` lies in the sum of disc and ellipsoid: p minus its nearest point of the disc is in the
/// ellipsoid.
bool contains(const SupportBound& bound, const Vec3& p) {
  const double rho = std::hypot(p.x(), p.z());
  const double keep = rho > bound.ring ? (rho - bound.ring) / rho : 0.0;
  return Vec3(keep * p.x(), p.y(), keep * p.z()).cwiseQuotient(bound.semiAxes).norm() <= 1.0 + 1e-9;
}

double furthest(const TriangleMesh& mesh, const Vec3& n) {
  double best = -1e300;
  for (const Vec3& v : mesh.vertices) best = std::max(best, n.dot(v));
  return best;
}

void checkBound(const TriangleMesh& mesh) {
  const SupportBound bound = boundSupport(mesh);
  REQUIRE(bound.ring >= 0.0);
  REQUIRE(bound.semiAxes.minCoeff() > 0.0);
  for (const Vec3& v : mesh.vertices) REQUIRE(contains(bound, v));
  std::mt19937 random(1);
  double radius = 0.0;
  for (const Vec3& v : mesh.vertices) radius = std::max(radius, v.norm());
  for (int n = 0; n < 500; ++n) {
    Vec3 direction = test::randomDirection(random);
    if (n < 6) direction = (n % 2 ? 1.0 : -1.0) * Vec3::Unit(n / 2);
    REQUIRE(bound.support(direction) >= furthest(mesh, direction) * (1.0 - 1e-12));
  }
}

}  // namespace

TEST_CASE("The support bound contains every vertex", "[shape]") {
  for (const test::NamedShape& shape : test::allShapes()) {
    CAPTURE(shape.name);
    checkBound(shape.shape->mesh());
  }
  for (unsigned seed = 0; seed < 30; ++seed) {
    CAPTURE(seed);
    checkBound(test::convexMesh(seed));
    checkBound(test::bumpyMesh(seed));
    TriangleMesh offCentre = test::convexMesh(seed);
    for (Vec3& v : offCentre.vertices) v += Vec3(1.5, -0.5, 0.7);
    checkBound(offCentre);
  }
  checkBound(sample::box({-1, -2, -3}, {1, 2, 3}));
  checkBound(sample::box({-4, -1e-9, -4}, {4, 1e-9, 4}));
}

TEST_CASE("The support bound is tight for ellipsoids and red cells", "[shape]") {
  std::mt19937 random(2);
  const auto slack = [&random](const TriangleMesh& mesh) {
    const SupportBound bound = boundSupport(mesh);
    double worst = 0.0;
    for (int n = 0; n < 500; ++n) {
      const Vec3 direction = test::randomDirection(random);
      const double exact = furthest(mesh, direction);
      worst = std::max(worst, bound.support(direction) / exact - 1.0);
    }
    return worst;
  };
  TriangleMesh ellipsoid = test::icosphere(4);
  for (Vec3& v : ellipsoid.vertices) v = v.cwiseProduct(Vec3(2.0, 0.8, 2.0));
  REQUIRE(slack(ellipsoid) < 0.01);
  REQUIRE(slack(test::redCellShape()->mesh()) < 0.03);
}
