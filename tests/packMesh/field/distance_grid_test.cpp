// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/field/distance_grid.h"
#include "packMesh/core/error.h"
#include "packMesh/mesh/closest_point.h"
#include "packMesh/mesh/mesh_repair.h"
#include "tests/packMesh/mesh/winding_number.h"
#include "tests/support/catch.h"
#include "tests/support/deformed.h"
#include "tests/support/shapes.h"

using namespace packmesh;

namespace {

/// Distance to a triangle by ternary search over chords parallel to an edge: slow and simple.
double distanceToTriangle(const Vec3& p, Vec3 a, Vec3 b, Vec3 c) {
  const auto alongEdge = [&](double s) {
    const Vec3 q0 = a + s * (b - a), q1 = a + s * (c - a);
    const double length = (q1 - q0).squaredNorm();
    const double t = length > 0.0 ? std::min(1.0, std::max(0.0, (p - q0).dot(q1 - q0) / length)) : 0.0;
    return (q0 + t * (q1 - q0) - p).norm();
  };
  double lo = 0.0, hi = 1.0;
  for (int step = 0; step < 100; ++step) {
    const double m1 = lo + (hi - lo) / 3.0, m2 = hi - (hi - lo) / 3.0;
    (alongEdge(m1) < alongEdge(m2) ? hi : lo) = alongEdge(m1) < alongEdge(m2) ? m2 : m1;
  }
  return alongEdge(0.5 * (lo + hi));
}

double bruteForce(const TriangleMesh& mesh, const Vec3& p) {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    best = std::min(best, distanceToTriangle(p, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)));
  const bool inside = std::abs(solidAngle(mesh.vertices, mesh.triangles, p)) > 2.0 * M_PI;
  return inside ? -best : best;
}

TriangleMesh nested() {
  TriangleMesh mesh = sample::sphere(Vec3::Zero(), 3.0, 10, 14),
               hole = sample::torus({0.1, 0.2, 0.0}, 1.5, 0.6, 16, 9);
  sample::append(mesh, hole);
  sample::append(mesh, sample::box({4.0, -1.0, -1.0}, {5.5, 1.0, 1.2}));
  repairClosed(mesh, "nested");
  return mesh;
}

TriangleMesh lShape() {
  return sample::voxels(4, 1.3, [](int i, int j, int k) {
    return k < 3 && (i == 0 || (j == 3 && i < 3) || (j == 0 && k == 0));
  });
}

/// A thin folded sheet: nearest features are edges and vertices nearly everywhere.
TriangleMesh blade() {
  TriangleMesh mesh = sample::box({-3.0, -0.02, -2.0}, {3.0, 0.02, 2.0});
  mesh.vertices[3].z() += 1.0;
  mesh.vertices[2].z() += 1.0;
  return mesh;
}

}  // namespace

TEST_CASE("ClosestPoint agrees with brute force", "[geometry][shape]") {
  for (const TriangleMesh& mesh :
       {nested(), lShape(), blade(), sample::torus(Vec3::Zero(), 3.0, 1.0, 20, 12)}) {
    const ClosestPoint surface(mesh);
    std::vector<double> expected;  // the same with every band
    for (const double band : {0.0, 0.7, 100.0}) {
      const DistanceGrid grid =
          sampleDistance(MeshHierarchy(mesh), boundingBox(mesh).grownBy(2.0), 0.3, band);
      REQUIRE(grid.box().contains(boundingBox(mesh).hi + 2.0 * Vec3::Ones()));
      std::size_t index = 0;
      for (int k = 0; k < grid.nodes[2]; ++k)
        for (int j = 0; j < grid.nodes[1]; ++j)
          for (int i = 0; i < grid.nodes[0]; ++i, ++index) {
            const Vec3 p = grid.origin + grid.spacing * Vec3(i, j, k);
            if (band == 0.0) {
              expected.push_back(surface.signedDistance(p));
              if (index % 997 == 0) CHECK(expected[index] == Approx(bruteForce(mesh, p)).margin(1e-6));
            }
            const double value = grid.value[index], exact = expected.at(index);
            const bool right = std::abs(exact) <= std::max(band, 3.0 * grid.spacing)
                                   ? std::abs(value - exact) < 1e-6
                                   : value * exact > 0.0 && std::abs(value) < 1.05 * std::abs(exact) + 1e-6 &&
                                         std::abs(value) > std::abs(exact) - 1e-6;
            if (!right) FAIL("at " << toText(p) << " " << value << " instead of " << exact);
          }
    }
  }
}

TEST_CASE("sampleDistance accounts for parts of the mesh outside its region", "[shape]") {
  const TriangleMesh mesh = sample::tube(
      -10.0, 10.0, 41, 20, [](double x) { return Vec3(x, 2.0 * std::sin(x), 0.0); },
      [](double) { return 3.0; });
  const ClosestPoint surface(mesh);
  const DistanceGrid grid =
      sampleDistance(MeshHierarchy(mesh), {{-1.0, -3.0, -2.0}, {2.0, 2.0, 4.0}}, 0.2, 0.4);
  for (std::size_t n = 0; n < grid.value.size(); ++n) {
    const std::size_t row = grid.nodes[0], plane = row * grid.nodes[1];
    const double expected =
        surface.signedDistance(grid.origin + grid.spacing * Vec3(n % row, n % plane / row, n / plane));
    if (std::abs(grid.value[n] - expected) > 0.35 * grid.spacing)
      FAIL(grid.value[n] << " instead of " << expected);
  }
}

TEST_CASE("DistanceGrid interpolates a sphere and its gradient, inside and outside the grid", "[shape]") {
  const TriangleMesh mesh = sample::sphere(Vec3::Zero(), 3.0, 60, 80);
  const DistanceGrid grid = sampleDistance(MeshHierarchy(mesh), boundingBox(mesh).grownBy(1.0), 0.1, 10.0);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(-3.9, 3.9);
  for (int n = 0; n < 2000; ++n) {
    const Vec3 p(coordinate(random), coordinate(random), coordinate(random));
    if (p.norm() < 1.0) continue;
    REQUIRE(grid.distance(p) == Approx(p.norm() - 3.0).margin(0.008));
    REQUIRE((grid.sample(p).gradient - p.normalized()).norm() < 0.15);
  }
  for (int n = 0; n < 500; ++n) {
    const Vec3 p = 2.0 * Vec3(coordinate(random), coordinate(random), coordinate(random));
    const double step = 1e-6;
    const Vec3 inGrid = p.cwiseMax(grid.box().lo).cwiseMin(grid.box().hi);
    REQUIRE(grid.distance(p) == Approx(grid.distance(inGrid) + (p - inGrid).norm()).margin(1e-9));
    for (int k = 0; k < 3; ++k) {
      const double slope =
          (grid.distance(p + step * Vec3::Unit(k)) - grid.distance(p - step * Vec3::Unit(k))) / (2 * step);
      REQUIRE(grid.sample(p).gradient[k] == Approx(slope).margin(1e-3));
    }
    REQUIRE(grid.sample(p).distance == Approx(grid.distance(p)).margin(1e-12));
  }
}

TEST_CASE("DistanceGrid has an error below its bound, also for meshes with thin parts", "[shape]") {
  for (const TriangleMesh& mesh : {nested(), lShape(), blade()}) {
    const DistanceGrid grid =
        sampleDistance(MeshHierarchy(mesh), boundingBox(mesh).grownBy(1.0), 0.25, 100.0);
    const ClosestPoint surface(mesh);
    std::mt19937 random(9);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    double worst = 0.0;
    for (int n = 0; n < 20000; ++n) {
      const Vec3 p =
          grid.box().lo + Vec3(unit(random), unit(random), unit(random)).cwiseProduct(grid.box().size());
      worst = std::max(worst, std::abs(grid.distance(p) - surface.signedDistance(p)));
    }
    CAPTURE(worst);
    REQUIRE(worst <= grid.interpolationError());
    REQUIRE(worst > 0.1 * grid.interpolationError());
  }
}

TEST_CASE("sampleDistance rejects what does not fit", "[shape][messages]") {
  const TriangleMesh mesh = sample::box(Vec3::Zero(), Vec3::Ones());
  REQUIRE_THROWS_WITH(sampleDistance(MeshHierarchy(mesh), {Vec3::Zero(), Vec3::Constant(1e4)}, 0.1, 1.0),
                      Contains("at most 2 GB"));
  REQUIRE_THROWS_AS(sampleDistance(MeshHierarchy(mesh), boundingBox(mesh), 0.0, 1.0), InputError);
  REQUIRE_THROWS_AS(sampleDistance(MeshHierarchy(mesh), Box(), 0.1, 1.0), InputError);
}

namespace {

/// Compares all nodes with the distances of a search.
void compare(const TriangleMesh& mesh, double spacing) {
  const DistanceGrid grid = sampleRoughly(mesh, boundingBox(mesh).grownBy(spacing), spacing);
  const ClosestPoint surface(mesh);
  std::size_t node = 0;
  for (int k = 0; k < grid.nodes[2]; ++k)
    for (int j = 0; j < grid.nodes[1]; ++j)
      for (int i = 0; i < grid.nodes[0]; ++i, ++node) {
        const double expected = surface.signedDistance(grid.origin + spacing * Vec3(i, j, k)),
                     found = grid.value[node];
        if (std::abs(expected) > 1e-5) REQUIRE((found < 0.0) == (expected < 0.0));
        REQUIRE(std::abs(found) >= std::abs(expected) - 1e-5);
        const double distance = std::abs(expected) / spacing;
        const double error = distance <= 1.0 ? 0.0 : distance < 1.5 ? 0.25 : 0.75;
        REQUIRE(std::abs(found) <= std::abs(expected) + 1e-5 + error * spacing);
      }
}

}  // namespace

TEST_CASE("A rough grid is exact next to the surface, and nearly so elsewhere", "[field]") {
  const std::shared_ptr<const Shape> red = test::redCellShape();
  for (const int seed : {1, 2, 3, 4}) {
    const TriangleMesh mesh{test::deformed(red->mesh(), seed), red->mesh().triangles};
    compare(mesh, 0.33);
    compare(mesh, 0.7);
  }
  compare(red->mesh(), 0.33);
}

TEST_CASE("Rows of a rough grid may meet vertices and edges", "[field]") {
  TriangleMesh octahedron;
  for (int axis = 0; axis < 3; ++axis)
    for (const double x : {1.0, -1.0}) octahedron.vertices.push_back(x * Vec3::Unit(axis));
  octahedron.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                          {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  compare(octahedron, 0.25);
  compare(octahedron, 0.5);
}
