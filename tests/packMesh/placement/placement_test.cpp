// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/placement/placement.h"
#include "packMesh/certificate/certificate.h"
#include "packMesh/certificate/certifier.h"
#include "tests/support/catch.h"
#include "tests/support/packings.h"
#include "tests/support/physics.h"

using namespace packmesh;

namespace {

bool same(const Pose& a, const Pose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs() && a.scale == b.scale;
}

Physics redCellsIn(const Box& bounds, std::uint64_t seed = 1) {
  Physics physics = test::physicsOf({test::redCellShape()}, makeBox(bounds, {true, true, true}));
  physics.seed = seed;
  return physics;
}

}  // namespace

TEST_CASE("Initial positions are uniform over a periodic box", "[placement]") {
  const Box bounds{{-5, 0, 10}, {15, 30, 20}};
  constexpr int count = 20000;
  const std::vector<Pose> poses = placeRandomly(redCellsIn(bounds), {}, 0, 0, 0, count);
  REQUIRE(poses.size() == count);
  Vec3 mean = Vec3::Zero(), squares = Vec3::Zero(), axis = Vec3::Zero();
  for (const Pose& pose : poses) {
    REQUIRE(bounds.contains(pose.position));
    REQUIRE(pose.scale == 1.0);
    REQUIRE(pose.orientation.norm() == Approx(1.0));
    const Vec3 u = (pose.position - bounds.lo).cwiseQuotient(bounds.size()), half = Vec3::Constant(0.5);
    mean += u;
    squares += (u - half).cwiseProduct(u - half);
    axis += pose.orientation * Vec3::UnitY();
  }
  REQUIRE((mean / count - Vec3::Constant(0.5)).norm() < 0.02);
  REQUIRE((squares / count - Vec3::Constant(1.0 / 12.0)).norm() < 0.01);
  REQUIRE((axis / count).norm() < 0.05);
}

TEST_CASE("Initial positions are more evenly spread than independent points", "[placement]") {
  const Box bounds{{0, 0, 0}, {50, 50, 50}};
  constexpr int perEdge = 5, count = 1000;
  for (const std::uint64_t seed : {1, 2, 3}) {
    std::vector<int> cells(perEdge * perEdge * perEdge, 0);
    for (const Pose& pose : placeRandomly(redCellsIn(bounds, seed), {}, 0, 0, 0, count)) {
      const Vec3 at = perEdge * pose.position.cwiseQuotient(bounds.size());
      ++cells[int(at.x()) + perEdge * (int(at.y()) + perEdge * int(at.z()))];
    }
    const double mean = double(count) / double(cells.size());
    double variance = 0.0;
    for (const int n : cells) variance += (n - mean) * (n - mean) / double(cells.size());
    CHECK(variance < 0.5 * mean);  // of independent points: the mean
  }
}

TEST_CASE("A pose is a function of the seed and the cell's number alone", "[placement]") {
  const Box bounds{{0, 0, 0}, {20, 20, 20}};
  const std::vector<Pose> all = placeRandomly(redCellsIn(bounds, 3), {}, 0, 0, 0, 50);
  const std::vector<Pose> some = placeRandomly(redCellsIn(bounds, 3), {}, 0, 0, 20, 10);
  for (int i = 0; i < 10; ++i) REQUIRE(same(some[i], all[20 + i]));
  const std::vector<Pose> other = placeRandomly(redCellsIn(bounds, 4), {}, 0, 0, 0, 50);
  for (int i = 0; i < 50; ++i) REQUIRE_FALSE(same(other[i], all[i]));
  Physics unrotated = redCellsIn(bounds, 3);
  unrotated.rotate = false;
  const std::vector<Pose> still = placeRandomly(unrotated, {}, 0, 0, 0, 50);
  for (int i = 0; i < 50; ++i) {
    REQUIRE(still[i].position == all[i].position);
    REQUIRE(still[i].orientation.coeffs() == Quaternion::Identity().coeffs());
  }
  REQUIRE(placeRandomly(redCellsIn(bounds, 3), {}, 0, 0, 0, 0).empty());
}

TEST_CASE("Initial positions are inside the lumen, and away from the wall where there is room",
          "[placement]") {
  const auto shape = test::redCellShape();
  const std::shared_ptr<const Container> sphere = makeSphere(Vec3(1, 2, 3), 10.0);
  const double thin = shape->bound().semiAxes.minCoeff();
  for (const Pose& pose : placeRandomly(test::physicsOf({shape}, sphere), {}, 0, 0, 0, 500))
    REQUIRE(sphere->wall()->distance(pose.position).distance >= thin);
  // No room: as far inside as the tries came.
  const std::shared_ptr<const Container> narrow = makeCylinder(Vec3::Zero(), 0, 0.5, 40.0, true);
  for (const Pose& pose : placeRandomly(test::physicsOf({shape}, narrow), {}, 0, 0, 0, 50))
    REQUIRE(narrow->wall()->distance(pose.position).distance > 0.4);
}

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
      CAPTURE(size, fraction);
      const Box box{Vec3(3, -4, 5), Vec3(3, -4, 5) + size};
      const auto count = std::int64_t(fraction * box.volume() / shape->volume());
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
  CHECK_THROWS_WITH(pack(problem), Contains("periodic along all axes"));
  problem = inColumns(40.0, 0.3);
  problem.physics.rotate = false;
  CHECK_THROWS_WITH(pack(problem), Contains("rotations are disabled"));
  problem = inColumns(40.0, 0.3);
  problem.physics.species.push_back(problem.physics.species[0]);
  CHECK_THROWS_WITH(pack(problem), Contains("another species does as well"));
  problem = inColumns(40.0, 0.3);
  problem.physics.species[0].freedom.cone = AxisCone{Vec3::UnitX(), 0.1};
  CHECK_THROWS_WITH(pack(problem), Contains("orientation of its cells is constrained"));
}
