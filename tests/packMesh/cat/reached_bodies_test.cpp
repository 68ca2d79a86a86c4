// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/cat_face_planes.h"

#include "tests/support/catch.h"
#include "tests/support/packings.h"

using namespace packmesh;

namespace {

constexpr double boxEdge = 20.0;  // of the box

/// Red cells around their axes y at full size, in a row along y in a periodic box.
struct Row {
  Physics physics = test::redCellProblem(test::periodicCube(boxEdge), 0.1).physics;
  std::vector<Body> cells;
  ChordPlanes chords{physics};

  explicit Row(const std::vector<double>& heights) {
    for (const double height : heights) {
      Pose pose;
      pose.position = {0.5 * boxEdge, height, 0.5 * boxEdge};
      cells.push_back(makeBody(std::int64_t(cells.size()), 0, 0, pose));
    }
  }
  CellSurroundings surroundings(double reach) const {
    return CellSurroundings(physics, cells, std::vector<double>(cells.size(), reach),
                            std::vector<double>(cells.size(), 0.0));
  }
  const TriangleMesh& mesh() const { return physics.shapes[0]->mesh(); }
  std::vector<std::vector<char>> pointsOf(const PlaneRequest& request, const ReachedBodies& reached) const {
    const auto levels = reachingMeshes(chords.levels(0), std::cbrt(physics.shapes[0]->volume()));
    return pointsWithinReach(
        request, reached, std::vector<const ReachingMesh*>(reached.members.size(), levels[0].get()), chords);
  }
};

std::size_t countOf(const std::vector<char>& points) {
  return std::size_t(std::count(points.begin(), points.end(), 1));
}

}  // namespace

TEST_CASE("Of cells that are not requested, only the surface near to requested ones has points") {
  const Row row({4.0, 6.8, 9.6});
  const CellSurroundings surroundings = row.surroundings(0.5);
  const PlaneRequest request{surroundings, {1}, 1.0, 0.5};
  const ReachedBodies reached = bodiesWithinReach(request);
  CHECK(reached.members == std::vector<std::int64_t>{0, 1, 2});
  REQUIRE(reached.bodies.size() == 3);
  const auto points = row.pointsOf(request, reached);
  for (int b = 0; b < 3; ++b) {
    CAPTURE(b);
    CHECK(reached.bodies[b].primary == (b == 1));
    CHECK(countOf(points[b]) > 30);
    for (std::size_t v = 0; v < points[b].size(); ++v) {
      const double y = row.mesh().vertices[v].y();
      if (b != 1 && points[b][v]) CHECK((b == 0 ? y : -y) > -0.5);
    }
  }
  // The requested one lies between two others that lie on one side of it each.
  CHECK(countOf(points[1]) > countOf(points[0]) + 30);
}

TEST_CASE("Images of a cell have points of their own") {
  const Row row({1.0, 18.5});  // neighbours across the boundary of the box
  const CellSurroundings surroundings = row.surroundings(0.6);
  const PlaneRequest request{surroundings, {0, 1}, 1.0, 0.5};
  const ReachedBodies reached = bodiesWithinReach(request);
  CHECK(reached.members == std::vector<std::int64_t>{0, 1});
  REQUIRE(reached.bodies.size() == 4);
  const auto points = row.pointsOf(request, reached);
  std::set<double> heights;
  for (std::size_t b = 0; b < points.size(); ++b) {
    const TetrahedraBody& body = reached.bodies[b];
    heights.insert(body.shift.y());
    CHECK(body.primary == body.shift.isZero(0.0));
    CHECK(points[b] == points[body.object == 0 ? 0 : points.size() - 1]);  // with one neighbour: all the same
  }
  CHECK(heights == std::set<double>{-boxEdge, 0.0, boxEdge});
}

TEST_CASE("Where the gap is wide, the vertices of a coarser level of detail are enough") {
  const Row narrow({6.0, 8.7}), wide({6.0, 9.4});  // red cells are 2.6 thick
  const auto pointsOf = [](const Row& row) {
    const CellSurroundings surroundings = row.surroundings(2.0);
    const PlaneRequest request{surroundings, {0, 1}, 1.0, 0.5};
    return countOf(row.pointsOf(request, bodiesWithinReach(request))[0]);
  };
  CHECK(2 * pointsOf(narrow) > 3 * pointsOf(wide));
  CHECK(pointsOf(wide) > 20);
}

TEST_CASE("Vertices of a level of detail are points up to a gap that is wider for coarser levels") {
  const LevelsOfDetail levels(test::icosphere(3));
  REQUIRE(levels.count() == 3);
  const auto meshes = reachingMeshes(levels, 1.6);
  for (int level = 0; level < 3; ++level) {
    CAPTURE(level);
    const ReachingMesh& mesh = *meshes[level];
    CHECK(mesh.hierarchy.mesh().vertices.size() == levels.mesh(level).vertices.size());
    std::map<double, std::size_t> counts;
    for (const double within : mesh.within) ++counts[within];
    CHECK(counts.size() == std::size_t(3 - level));
    CHECK(counts[std::numeric_limits<double>::infinity()] == levels.mesh(2).vertices.size());
  }
  CHECK(meshes[0]->within.back() < 0.2);
}

TEST_CASE("Corners of triangles that are large for a body are always points") {
  const auto always = [](const TriangleMesh& mesh, double size) {
    return countOf(reachingMeshes(LevelsOfDetail(mesh), size)[0]->always);
  };
  CHECK(always(sample::box(Vec3::Zero(), Vec3::Ones()), 1.0) == 8);
  CHECK(always(test::icosphere(3), 1.6) == 0);
  CHECK(always(test::icosphere(0), 1.4) == 12);
}
