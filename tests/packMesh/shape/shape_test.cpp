// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/shape/shape.h"
#include "packMesh/shape/surface_distance.h"
#include "tests/support/catch.h"
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

namespace {

using Point = std::array<float, 3>;

Point pointOf(const SamplePoints& s, int i) {
  return {s.x[i], s.y[i], s.z[i]};
}
Vec3 toVec3(const Point& p) {
  return {p[0], p[1], p[2]};
}

std::set<Point> allPoints(const SamplePoints& s) {
  std::set<Point> points;
  for (int i = 0; i < s.clusters * SamplePoints::width; ++i) points.insert(pointOf(s, i));
  return points;
}

void checkLayout(const SamplePoints& s) {
  const std::size_t points = std::size_t(s.clusters) * SamplePoints::width;
  REQUIRE((s.x.size() == points && s.y.size() == points && s.z.size() == points));
  REQUIRE(s.radius.size() % SamplePoints::width == 0);
  REQUIRE(s.radius.size() >= std::size_t(s.clusters));
  REQUIRE((s.centerX.size() == s.radius.size() && s.centerY.size() == s.radius.size() &&
           s.centerZ.size() == s.radius.size()));
  std::size_t distinct = 0;
  for (int c = 0; c < s.clusters; ++c) {
    const Vec3 center(s.centerX[c], s.centerY[c], s.centerZ[c]);
    std::map<Point, int> times;
    for (int k = 0; k < SamplePoints::width; ++k) {
      const Point p = pointOf(s, c * SamplePoints::width + k);
      REQUIRE((toVec3(p) - center).norm() <= s.radius[c]);
      ++times[p];
    }
    int rarest = SamplePoints::width, mostOften = 0;
    for (const auto& [point, n] : times) {
      rarest = std::min(rarest, n);
      mostOften = std::max(mostOften, n);
    }
    REQUIRE(mostOften <= rarest + 1);
    if (s.clusters > 1) REQUIRE(mostOften <= 2);
    distinct += times.size();
  }
  REQUIRE(std::size_t(s.clusters) ==
          (distinct + SamplePoints::width - 1) / SamplePoints::width);  // as few as can be
}

}  // namespace

TEST_CASE("Every vertex is a sample, and every surface point is near one", "[shape]") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<TriangleMesh> meshes = {sample::box({-1, -2, -3}, {1, 2, 3}), test::icosphere(0, 4.0)};
  for (const test::NamedShape& shape : test::allShapes()) meshes.push_back(shape.shape->mesh());
  for (std::size_t m = 0; m < meshes.size(); ++m)
    for (const double spacing : {0.3, 0.85, 2.0}) {
      CAPTURE(m, spacing);
      const TriangleMesh& mesh = meshes[m];
      const SamplePoints samples = sampleSurface(mesh, spacing);
      checkLayout(samples);
      const std::set<Point> points = allPoints(samples);
      for (const Vec3& v : mesh.vertices) REQUIRE(points.count({float(v.x()), float(v.y()), float(v.z())}));
      for (int n = 0; n < 300; ++n) {
        const std::size_t t = random() % mesh.triangles.size();
        double u = unit(random), v = unit(random);
        if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
        const Vec3 &a = mesh.corner(t, 0), &b = mesh.corner(t, 1), &c = mesh.corner(t, 2);
        const Vec3 p = a + u * (b - a) + v * (c - a);
        double nearest = 1e300;
        for (const Point& q : points) nearest = std::min(nearest, (toVec3(q) - p).norm());
        REQUIRE(nearest <= spacing);
      }
    }
}

TEST_CASE("Samples lie on the surface, also for meshes far from the origin", "[shape]") {
  TriangleMesh mesh = sample::box({100, 200, -300}, {104, 203, -299});
  const SamplePoints samples = sampleSurface(mesh, 0.5);
  checkLayout(samples);
  for (const Point& p : allPoints(samples)) {
    const Vec3 q = toVec3(p), lo(100, 200, -300), hi(104, 203, -299);
    const double off = std::min((q - lo).cwiseAbs().minCoeff(), (q - hi).cwiseAbs().minCoeff());
    REQUIRE(off < 1e-4);
  }
}

TEST_CASE("Coarse samples are an evenly spread subset of the vertices", "[shape]") {
  for (const test::NamedShape& shape : test::allShapes()) {
    CAPTURE(shape.name);
    const TriangleMesh& mesh = shape.shape->mesh();
    const SamplePoints coarse = sampleCoarsely(mesh);
    checkLayout(coarse);
    const std::set<Point> points = allPoints(coarse);
    std::set<Point> vertices;
    for (const Vec3& v : mesh.vertices) vertices.insert({float(v.x()), float(v.y()), float(v.z())});
    for (const Point& p : points) REQUIRE(vertices.count(p));
    REQUIRE(points.size() >= std::min<std::size_t>(32, vertices.size() / 4));
    REQUIRE(points.size() <= std::max<std::size_t>(32, vertices.size() / 4 + 1));
    for (const Point& v : vertices) {
      double nearest = 1e300;
      for (const Point& p : points) nearest = std::min(nearest, (toVec3(p) - toVec3(v)).norm());
      REQUIRE(nearest < 0.6 * shape.shape->radius());
    }
  }
}

TEST_CASE("A template of another size has the volume, the extents and the distances of that size") {
  constexpr double factor = 0.6;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int examined = 0;
  for (const auto& [name, shape] : test::allShapes()) {
    if (shape->undeformed()) continue;
    CAPTURE(name);
    ++examined;
    const Shape small(*shape, factor);
    CHECK(small.volume() == Approx(factor * factor * factor * shape->volume()));
    CHECK(small.radius() == Approx(factor * shape->radius()));
    CHECK(small.halfThickness() == Approx(factor * shape->halfThickness()));
    CHECK(small.bound().semiAxes.maxCoeff() == Approx(factor * shape->bound().semiAxes.maxCoeff()));
    CHECK(small.mesh().triangles == shape->mesh().triangles);
    const SurfaceDistance distance(*shape), ofSmall(small);
    for (int n = 0; n < 300; ++n) {
      const Vec3 p = 1.2 * shape->radius() * unit(random) * test::randomDirection(random);
      CHECK(ofSmall.sample(factor * p).distance ==
            Approx(factor * distance.sample(p).distance).margin(1e-5 * shape->radius()));
    }
  }
  CHECK(examined >= 3);
}
