// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/placement/columns.h"

#include <catch2/catch.hpp>
#include <set>

#include "packMesh/certificate/certificate.h"
#include "packMesh/certificate/certify.h"
#include "tests/support/packings.h"

using namespace packmesh;

namespace {

/// The certificate of cells where the columns have them.
Certificate certificateOf(const Columns& columns, const Shape& shape, std::int64_t count, const Box& box) {
  const auto container = makeBox(box, {true, true, true});
  std::vector<PlacedCell> cells;
  for (std::int64_t i = 0; i < count; ++i) {
    const Pose pose = columns.pose(i);
    REQUIRE(box.contains(pose.position));
    cells.push_back({0, 0, pose.placement()});
  }
  CertificateInput input;
  input.shapes = {&shape};
  input.walls = {nullptr};
  input.container = container.get();
  input.cells = &cells;
  return certify(input);
}

PackingProblem inColumns(double edge, double fraction, std::uint64_t seed = 1) {
  PackingProblem problem = test::redCellProblem(test::periodicCube(edge), fraction, seed);
  problem.physics.species[0].inColumns = true;
  return problem;
}

}  // namespace

TEST_CASE("Columns with enough room do not meet in boxes of any shape", "[placement]") {
  const test::ShapePointer shape = test::redCellShape();
  constexpr double gap = 0.02;
  int roomy = 0;
  for (const Vec3& size :
       {Vec3(30, 30, 30), Vec3(50, 50, 50), Vec3(25, 40, 33), Vec3(20, 20, 90), Vec3(61, 17, 43)})
    for (const double fraction : {0.2, 0.45, 0.6}) {
      CAPTURE(size.transpose(), fraction);
      const Box box{Vec3(3, -4, 5), Vec3(3, -4, 5) + size};
      const auto count = static_cast<std::int64_t>(fraction * box.volume() / shape->volume());
      const Columns columns(*shape, count, box, gap, 7);
      CHECK(columns.columnCount() > 0);
      const Certificate certificate = certificateOf(columns, *shape, count, box);
      CHECK(certificate.cells == count);
      if (columns.room() < 1.0) continue;
      ++roomy;
      CHECK(certificate.clean());
      CHECK(certificate.minimumGap >= 0.99 * gap);
    }
  CHECK(roomy >= 12);
}

TEST_CASE("Cells of any shape are stacked in columns by their bounding cylinder", "[placement]") {
  const Box box{Vec3::Zero(), Vec3::Constant(60)};
  for (const test::NamedShape& one : test::allShapes()) {
    CAPTURE(one.name);
    const Columns columns(*one.shape, 40, box, 0.1, 3);
    REQUIRE(columns.room() > 1.0);
    CHECK(certificateOf(columns, *one.shape, 40, box).clean());
  }
  // One cell alone, and so many that they cannot all have room.
  CHECK(Columns(*test::redCellShape(), 1, box, 0.1, 3).room() > 5.0);
  CHECK(Columns(*test::redCellShape(), 2200, box, 0.1, 3).room() < 1.0);
}

TEST_CASE("Columns depend on the seed, and poses depend on nothing else", "[placement]") {
  const Box box{Vec3::Zero(), Vec3::Constant(30)};
  const Columns first(*test::redCellShape(), 150, box, 0.02, 1),
      same(*test::redCellShape(), 150, box, 0.02, 1), other(*test::redCellShape(), 150, box, 0.02, 2);
  std::set<double> seen;
  for (std::int64_t i = 149; i >= 0; --i) {
    CHECK(first.pose(i).position == same.pose(i).position);
    CHECK(first.pose(i).orientation.coeffs() == same.pose(i).orientation.coeffs());
    CHECK(first.pose(i).position != other.pose(i).position);
    seen.insert(first.pose(i).position.squaredNorm());
  }
  CHECK(seen.size() == 150);
}

TEST_CASE("Packings in columns are denser than random ones can be", "[packing]") {
  for (const auto& [edge, fraction] : {std::pair{50.0, 0.62}, std::pair{50.0, 0.64}, std::pair{43.0, 0.62}}) {
    CAPTURE(edge, fraction);
    const PackingProblem problem = inColumns(edge, fraction);
    const PackingResult result = pack(problem);
    CHECK(result.outcome == Outcome::certified);
    CHECK(result.certificate.clean());
    CHECK(std::int64_t(result.cells.size()) == problem.physics.species[0].count);
  }
}

TEST_CASE("Platelets fit between columns", "[packing]") {
  PackingProblem problem = inColumns(40.0, 0.45);
  problem.physics.add("PLT", test::hemocellShape("PLT"), 30);
  CHECK(pack(problem).outcome == Outcome::certified);
}

TEST_CASE("Columns are rejected where they are not possible", "[packing]") {
  PackingProblem problem = inColumns(40.0, 0.3);
  problem.physics.container = makeCylinder(Vec3(20, 20, 20), 2, 15, 40, true);
  CHECK_THROWS_WITH(pack(problem), Catch::Contains("periodic along all axes"));
  problem = inColumns(40.0, 0.3);
  problem.physics.rotate = false;
  CHECK_THROWS_WITH(pack(problem), Catch::Contains("rotations are disabled"));
  problem = inColumns(40.0, 0.3);
  problem.physics.species.push_back(problem.physics.species[0]);
  CHECK_THROWS_WITH(pack(problem), Catch::Contains("another species does as well"));
  problem = inColumns(40.0, 0.3);
  problem.physics.species[0].freedom.cone = AxisCone{Vec3::UnitX(), 0.1};
  CHECK_THROWS_WITH(pack(problem), Catch::Contains("orientation of its cells is constrained"));
}
