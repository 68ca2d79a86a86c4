// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/polygon.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "packMesh/core/error.h"
#include "packMesh/core/random.h"
#include "packMesh/mesh/mesh_repair.h"

using namespace packmesh;
using Catch::Matchers::Contains;

namespace {

using Vector2 = Eigen::Vector2d;

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

std::vector<std::array<Vector2, 2>> segmentsOf(const Polygon& polygon) {
  std::vector<std::array<Vector2, 2>> segments;
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
      REQUIRE(static_cast<int>(triangles.size()) == corners - 2);
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
  for (auto& s : segmentsOf(star(4, 9))) segments.push_back({s[1] + Vector2(20, 0), s[0] + Vector2(20, 0)});
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
