// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/openings.h"
#include "packMesh/container/vessel.h"
#include "packMesh/core/error.h"
#include "packMesh/core/random.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/mesh_repair.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

/// A star-shaped polygon with random radii.
Polygon star(std::uint64_t seed, int corners) {
  Polygon polygon;
  for (int i = 0; i < corners; ++i) {
    const double r = 1.0 + 4.0 * uniform4(seed, RandomStream::position, i, 0)[0];
    const double angle = 2.0 * std::acos(-1.0) * i / corners;
    polygon.emplace_back(r * std::cos(angle), r * std::sin(angle));
  }
  return polygon;
}

std::vector<std::array<Vec2, 2>> segmentsOf(const Polygon& polygon) {
  std::vector<std::array<Vec2, 2>> segments;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    segments.push_back({polygon[i], polygon[(i + 1) % polygon.size()]});
  return segments;
}

}  // namespace

TEST_CASE("Triangulations of any polygon have its area, and prisms over them are closed") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    for (const int corners : {3, 4, 7, 40}) {
      const Polygon polygon = star(seed, corners);
      const std::vector<Triangle> triangles = triangulated(polygon);
      REQUIRE(int(triangles.size()) == corners - 2);
      double sum = 0.0;
      for (const Triangle& t : triangles) {
        const double area = twiceArea({polygon[t[0]], polygon[t[1]], polygon[t[2]]});
        CHECK(area >= 0.0);
        sum += area;
      }
      CHECK(sum == Approx(twiceArea(polygon)));
      for (int axis = 0; axis < 3; ++axis) {
        TriangleMesh prism = prismOver(polygon, axis, -1.0, 2.0);
        CHECK(signedVolume(prism) == Approx(1.5 * twiceArea(polygon)));
        CHECK(repairClosed(prism, "prism").empty());
        CHECK(boundingBox(prism).lo[axis] == -1.0);
      }
    }
}

TEST_CASE("Triangulation handles collinear points") {
  const Polygon square = {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 1}, {3, 3}, {1.5, 3}, {0, 3}, {0, 1}};
  double sum = 0.0;
  for (const Triangle& t : triangulated(square)) sum += twiceArea({square[t[0]], square[t[1]], square[t[2]]});
  CHECK(sum == Approx(18.0));
}

TEST_CASE("Loops are found among segments in any order and direction") {
  auto segments = segmentsOf(star(3, 12));
  for (auto& s : segmentsOf(star(4, 9))) segments.push_back({s[1] + Vec2(20, 0), s[0] + Vec2(20, 0)});
  for (std::size_t i = 0; i < segments.size(); i += 3)
    std::swap(segments[i], segments[segments.size() - 1 - i]);
  for (std::size_t i = 0; i < segments.size(); i += 2) std::swap(segments[i][0], segments[i][1]);
  const std::vector<Polygon> loops = loopsOf(segments);
  REQUIRE(loops.size() == 2);
  double area = 0.0;
  for (const Polygon& loop : loops) {
    CHECK(twiceArea(loop) > 0.0);
    area += twiceArea(loop);
  }
  CHECK(area == Approx(twiceArea(star(3, 12)) + twiceArea(star(4, 9))));
}

TEST_CASE("Polygons that are not simple are rejected") {
  CHECK_THROWS_WITH(loopsOf({}), Contains("cross-section is empty"));
  auto open = segmentsOf(star(1, 8));
  open.pop_back();
  CHECK_THROWS_WITH(loopsOf(open), Contains("not closed"));
  auto ring = segmentsOf(star(1, 8));
  for (const auto& s : segmentsOf(star(1, 8))) ring.push_back({0.5 * s[0], 0.5 * s[1]});
  CHECK_THROWS_WITH(loopsOf(ring), Contains("has a hole"));
  CHECK_THROWS_WITH(triangulated({{0, 0}, {0, 2}, {2, 2}, {2, 0}}), Contains("clockwise"));
}

namespace {

/// `mesh` without the triangles in the planes `x`.
TriangleMesh opened(TriangleMesh mesh, const std::vector<double>& planes) {
  const auto isCap = [&](const Triangle& t) {
    return std::any_of(planes.begin(), planes.end(), [&](double x) {
      return std::all_of(t.begin(), t.end(),
                         [&](int v) { return std::abs(mesh.vertices[v].x() - x) < 1e-9; });
    });
  };
  mesh.triangles.erase(std::remove_if(mesh.triangles.begin(), mesh.triangles.end(), isCap),
                       mesh.triangles.end());
  return mesh;
}

std::string refusalToClose(TriangleMesh mesh) {
  std::vector<CappedOpening> capped;
  const std::string message = test::messageOf<MeshError>([&] { repairClosed(mesh, "tube.stl", &capped); });
  CHECK(capped.empty());
  return message;
}

}  // namespace

TEST_CASE("Flat openings are capped", "[geometry][openings]") {
  const TriangleMesh whole = sample::straightTube(0.0, 30.0, 5.0, 7, 24);
  const double area = 12.0 * 25.0 * std::sin(2.0 * M_PI / 24.0);  // of the polygon with 24 corners
  for (const std::vector<double>& ends : {std::vector<double>{30.0}, {0.0}, {0.0, 30.0}}) {
    TriangleMesh mesh = opened(whole, ends);
    REQUIRE(mesh.triangles.size() < whole.triangles.size());
    CHECK_THROWS_WITH(repairClosed(mesh, "x"), Contains("not closed"));
    mesh = opened(whole, ends);
    std::vector<CappedOpening> capped;
    CHECK(repairClosed(mesh, "x", &capped).size() <= 1);  // the unused vertex in the middle of an end
    REQUIRE(capped.size() == ends.size());
    for (const CappedOpening& opening : capped) {
      CHECK(opening.area == Approx(area));
      CHECK(opening.edges == 24);
      CHECK(opening.center.y() == Approx(0.0).margin(1e-12));
    }
    CHECK(signedVolume(mesh) == Approx(30.0 * area));
    CHECK(surfaceArea(mesh) == Approx(surfaceArea(whole)));
    CHECK(repairClosed(mesh, "x").empty());
    for (const Vec3& v : mesh.vertices) CHECK((v.x() >= 0.0 && v.x() <= 30.0));
    const auto vessel = makeVessel(mesh, VesselEnds{0, 0.0, 30.0, false}, 0.5);  // has flat ends
    CHECK(vessel->volume() == Approx(30.0 * area));
  }
}

TEST_CASE("An opening may be a refined polygon, oblique, and not convex", "[geometry][openings]") {
  // A prism over a polygon with refined edges.
  const auto prism = [](const std::vector<Vec3>& corners, int parts, const Vec3& along) {
    TriangleMesh mesh;
    std::vector<Vec3> outline;
    for (std::size_t i = 0; i < corners.size(); ++i)
      for (int k = 0; k < parts; ++k)
        outline.push_back(corners[i] +
                          (corners[(i + 1) % corners.size()] - corners[i]) * (double(k) / parts));
    const int n = int(outline.size());
    for (const Vec3& p : outline) mesh.vertices.push_back(p);
    for (const Vec3& p : outline) mesh.vertices.push_back(p + along);
    for (int i = 0; i < n; ++i) {
      const int j = (i + 1) % n;
      mesh.triangles.insert(mesh.triangles.end(), {{i, j, n + j}, {i, n + j, n + i}});
    }
    return mesh;
  };
  const std::vector<Vec3> square = {{0, 0, 0}, {0, 4, 0}, {0, 4, 4}, {0, 0, 4}},
                          ell = {{0, 0, 0}, {0, 6, 0}, {0, 6, 2}, {0, 1, 2}, {0, 1, 6}, {0, 0, 6}};
  const double squareArea = 16.0, ellArea = 16.0;
  for (const auto& [corners, area] : {std::pair(square, squareArea), std::pair(ell, ellArea)})
    for (const int parts : {1, 5})
      for (const Vec3& along : {Vec3(10, 0, 0), Vec3(10, 3, 2), Vec3(-10, 0, 0)}) {
        for (const Mat3& turned :
             {Mat3(Mat3::Identity()), Quaternion(0.9, 0.3, 0.2, 0.1).normalized().toRotationMatrix()}) {
          TriangleMesh mesh = prism(corners, parts, along);
          for (Vec3& v : mesh.vertices) v = turned * v;
          std::vector<CappedOpening> capped;
          repairClosed(mesh, "x", &capped);
          REQUIRE(capped.size() == 2);
          CHECK(capped[0].area == Approx(area));
          CHECK(capped[1].edges == corners.size() * parts);
          CHECK(signedVolume(mesh) == Approx(10.0 * area));
        }
      }
}

TEST_CASE("Openings that are not flat are refused, saying what to do", "[geometry][openings][messages]") {
  TriangleMesh tube = opened(sample::straightTube(0.0, 30.0, 5.0, 7, 24), {30.0});
  for (Vec3& v : tube.vertices)
    if (v.x() > 29.0) v.x() += 0.02 * v.y() * v.y();
  const std::string bent = refusalToClose(tube);
  CHECK_THAT(bent, Contains("the opening at (30.3333, ") &&
                       Contains("with 24 edges is not flat: it deviates from a plane by 0.333"));
  CHECK_THAT(bent, Contains("Cut the end off by a plane, or close it in a mesh editor"));

  TriangleMesh hole = sample::sphere(Vec3::Zero(), 5.0, 12, 16);
  hole.triangles.erase(hole.triangles.begin() + 100);
  TriangleMesh closed = hole;
  std::vector<CappedOpening> capped;
  repairClosed(closed, "x", &capped);  // a single triangle is flat
  CHECK(capped.size() == 1);

  // A ring between two tubes.
  TriangleMesh ring = opened(sample::straightTube(0.0, 30.0, 5.0, 7, 24), {30.0});
  sample::append(ring, opened(sample::straightTube(5.0, 30.0, 2.0, 7, 12), {30.0}));
  CHECK_THAT(refusalToClose(ring), Contains("surrounds another one in the same plane"));

  // Two triangles that meet in a vertex.
  TriangleMesh open;
  open.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 1}};
  open.triangles = {{0, 1, 2}, {0, 3, 4}};
  CHECK_THAT(refusalToClose(open), Contains("several openings meet at (0, 0, 0)"));
}

TEST_CASE("Holes that are nearly flat are closed where that is allowed", "[geometry][openings]") {
  TriangleMesh whole = sample::straightTube(0.0, 30.0, 5.0, 7, 24);
  for (Vec3& v : whole.vertices)
    if (v.x() == 30.0) v.x() += 0.02 * v.y() * v.z();  // a saddle, 0.25 high
  TriangleMesh mesh;
  for (const Triangle& t : whole.triangles)
    if (std::any_of(t.begin(), t.end(), [&](int v) { return whole.vertices[v].x() < 28.0; }))
      mesh.triangles.push_back(t);
  mesh.vertices = whole.vertices;
  CHECK_THAT(refusalToClose(mesh), Contains("is not flat: it deviates from a plane by 0.25"));
  std::vector<CappedOpening> capped;
  repairClosed(mesh, "x", &capped, tolerance::flatHoleFraction);
  REQUIRE(capped.size() == 1);
  CHECK(capped[0].deviation == Approx(0.25).epsilon(0.01));
  CHECK(signedVolume(mesh) == Approx(signedVolume(whole)).epsilon(1e-3));
  CHECK(repairClosed(mesh, "again").empty());
}
