// SPDX-License-Identifier: AGPL-3.0-or-later
// Reading, repairing and preparing meshes takes steps in proportion to their triangles, also for degenerate
// ones. Steps are counted by poll(), so that the tests do not depend on the speed of the machine.

#include "packMesh/core/error.h"
#include "packMesh/core/poll.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/mesh/mesh_repair.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/shape/shape.h"
#include "tests/packMesh/mesh/test_meshes.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/packMesh/write_mesh.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;

namespace {

/// Number of polls during `work`; errors of the mesh end it.
double pollsOf(const std::function<void()>& work) {
  double polls = 0.0;
  const PollScope scope([&] { ++polls; });
  try {
    work();
  } catch (const MeshError&) {
  }
  return polls;
}

/// Treats meshes of n and 8 n triangles.
void requireProportional(
    TriangleMesh (*make)(int size), int size,
    const std::function<void(TriangleMesh&)>& treat = [](TriangleMesh& mesh) { repairClosed(mesh, "x"); }) {
  TriangleMesh small = make(size), large = make(8 * size);
  REQUIRE(large.triangles.size() > 7 * small.triangles.size());
  const double few = pollsOf([&] { treat(small); }), many = pollsOf([&] { treat(large); });
  CAPTURE(few, many);
  CHECK(many <= 16.0 * few + 100.0);
}

/// A prism over a polygon with n corners, closed by fans around the centres of its ends.
TriangleMesh tubeWithFans(int n) {
  TriangleMesh mesh;
  for (const double z : {0.0, 1.0}) {
    mesh.vertices.push_back({0.0, 0.0, z});
    for (int i = 0; i < n; ++i)
      mesh.vertices.push_back({std::cos(2.0 * M_PI * i / n), std::sin(2.0 * M_PI * i / n), z});
  }
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n, a = 1 + i, b = 1 + j, c = n + 2 + i, d = n + 2 + j;
    mesh.triangles.insert(mesh.triangles.end(), {{0, b, a}, {n + 1, c, d}, {a, b, d}, {a, d, c}});
  }
  return mesh;
}

/// A tetrahedron, one edge of which is divided into n parts, on the side of one triangle by n triangles
/// without area in a fan around an end of the edge.
TriangleMesh collinearFan(int n) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 1, 0}, {0, 0, 1}};
  for (int i = 0; i <= n; ++i) mesh.vertices.push_back({double(i), 0, 0});
  mesh.triangles = {{0, 2, 1}, {0, 1, n + 2}, {1, 2, n + 2}};
  for (int i = 0; i < n; ++i) mesh.triangles.push_back({0, 3 + i, 2 + i});
  for (int i = 1; i < n; ++i) mesh.triangles.push_back({2, 2 + i, 3 + i});
  return mesh;
}

TriangleMesh allOnALine(int n) {
  TriangleMesh mesh = tubeWithFans(n);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    mesh.vertices[i] = Vec3::Constant(double(i * 7919 % 100003));
  return mesh;
}

TriangleMesh allInAPoint(int n) {
  TriangleMesh mesh = tubeWithFans(n);
  for (Vec3& v : mesh.vertices) v = Vec3::Ones();
  return mesh;
}

TriangleMesh allInAPlane(int n) {
  TriangleMesh mesh = tubeWithFans(n);
  for (Vec3& v : mesh.vertices) v.z() = 0.0;
  return mesh;
}

TriangleMesh everythingTwice(int n) {
  TriangleMesh mesh = tubeWithFans(n);
  const std::vector<Triangle> triangles = mesh.triangles;
  mesh.triangles.insert(mesh.triangles.end(), triangles.begin(), triangles.end());
  return mesh;
}

/// n tetrahedra in a cube.
TriangleMesh tetrahedraInCube(int n) {
  const int edge = int(std::ceil(std::cbrt(n)));
  TriangleMesh mesh = sample::box(-Vec3::Ones(), Vec3::Constant(2.0 * edge));
  for (int i = 0; i < n; ++i) {
    const Vec3 at(2.0 * (i % edge), 2.0 * (i / edge % edge), 2.0 * (i / edge / edge));
    const int v = int(mesh.vertices.size());
    for (const Vec3& corner : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)})
      mesh.vertices.push_back(at + corner);
    mesh.triangles.insert(mesh.triangles.end(),
                          {{v, v + 2, v + 1}, {v, v + 1, v + 3}, {v, v + 3, v + 2}, {v + 1, v + 2, v + 3}});
  }
  return mesh;
}

/// An open surface, every vertex of which is on an open edge in a plane perpendicular to x.
TriangleMesh openStrip(int n) {
  TriangleMesh mesh;
  for (int i = 0; i <= n; ++i) mesh.vertices.push_back({0.0, double(i / 2), double(i % 2)});
  for (int i = 0; i + 2 <= n; ++i)
    mesh.triangles.push_back(i % 2 ? Triangle{i + 1, i, i + 2} : Triangle{i, i + 1, i + 2});
  return mesh;
}

}  // namespace

TEST_CASE("Repairing takes steps in proportion to the triangles", "[geometry][reading]") {
  for (const auto make :
       {tubeWithFans, allOnALine, allInAPoint, allInAPlane, everythingTwice, tetrahedraInCube})
    requireProportional(make, 1000);
  requireProportional(openStrip, 2000);
  requireProportional([](int n) { return sample::sphere(Vec3::Zero(), 3.0, 2 * n / 40, 20); }, 400);
  requireProportional(collinearFan, 1000, [](TriangleMesh& mesh) { removeFlatTriangles(mesh); });
}

TEST_CASE("A fan of triangles without area is removed", "[geometry][reading]") {
  TriangleMesh mesh = collinearFan(500);
  const double volume = signedVolume(mesh);
  CHECK(removeFlatTriangles(mesh) == 499);
  CHECK(signedVolume(mesh) == Approx(volume));
  CHECK_NOTHROW(repairClosed(mesh, "x"));
}

TEST_CASE("Components that contain others are oriented by all that contain them", "[geometry][reading]") {
  TriangleMesh mesh = tetrahedraInCube(27);
  const double outer = boundingBox(mesh).volume();
  const auto repairs = repairClosed(mesh, "x");
  CHECK(repairs == std::vector<std::string>{"x: flipped 27 surfaces that were inside out"});
  CHECK(signedVolume(mesh) == Approx(outer - 27.0 / 6.0));
}

TEST_CASE("Near vertices are those connected by steps, however many there are", "[geometry][reading]") {
  std::mt19937 random(3);
  for (const double distance : {0.02, 0.1, 0.3}) {
    std::vector<Vec3> points;
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (int i = 0; i < 400; ++i) points.push_back({unit(random), unit(random), 0.1 * unit(random)});
    std::vector<int> expected(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) expected[i] = int(i);
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t j = 0; j < points.size(); ++j)
          if ((points[i] - points[j]).squaredNorm() < distance * distance && expected[i] > expected[j])
            expected[i] = expected[j], changed = true;
    }
    CHECK(firstOfNearVertices(points, distance) == expected);
  }
  const std::vector<Vec3> crowd(20000, Vec3::Ones());
  CHECK(firstOfNearVertices(crowd, 1e-3) == std::vector<int>(20000, 0));
}

TEST_CASE("Coordinates are limited", "[geometry][reading][messages]") {
  const test::TemporaryFolder folder;
  for (const double factor : {1e155, 1e200, 1e13}) {
    TriangleMesh mesh = test::redCell(1);
    for (Vec3& v : mesh.vertices) v *= factor;
    CHECK_THROWS_WITH(repairClosed(mesh, "x"), Contains("at most 1e+12 is possible"));
    for (const char* name : {"cell.off", "cell.stl", "cell.obj", "cell.ply"}) {
      test::writeMesh(folder.path() / name, mesh);
      CHECK_THROWS_WITH(readMesh(folder.path() / name), Contains("expected a coordinate of at most 1e+12"));
    }
  }
  TriangleMesh mesh = test::redCell(1);
  for (Vec3& v : mesh.vertices) v *= 1e11;
  CHECK_NOTHROW(repairClosed(mesh, "x"));
}

TEST_CASE("Tiny coordinates end, too", "[geometry][reading]") {
  for (const double factor : {1e-20, 1e-155, 1e-200, 1e-310}) {
    TriangleMesh mesh = test::redCell(3);
    for (Vec3& v : mesh.vertices) v *= factor;
    CHECK(pollsOf([&] { repairClosed(mesh, "x"); }) < 1000.0);
  }
}

TEST_CASE("Work on a mesh can be ended at every poll", "[geometry][reading]") {
  struct Ended {};
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "cell.off";
  test::writeMesh(file, test::redCell(1));
  const auto prepare = [&] {
    TriangleMesh mesh = readMesh(file);
    repairClosed(mesh, "x");
    const Shape shape(mesh);
  };
  int polls = 0;
  {
    const PollScope scope([&] { ++polls; });
    prepare();
  }
  REQUIRE(polls > 100);
  for (int last = 1; last <= polls; last += 1 + last) {
    int left = last;
    const PollScope scope([&] {
      if (--left == 0) throw Ended();
    });
    CHECK_THROWS_AS(prepare(), Ended);
  }
  CHECK_NOTHROW(prepare());  // nothing is polled any more
}
