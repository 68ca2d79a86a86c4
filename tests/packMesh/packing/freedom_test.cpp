// SPDX-License-Identifier: AGPL-3.0-or-later
// Cells that are held back: fixed ones, axes in a cone, centres in a region, distances from the wall.

#include "packMesh/container/region.h"
#include "packMesh/container/side_wall.h"
#include "packMesh/core/error.h"
#include "packMesh/core/random.h"
#include "tests/support/catch.h"
#include "tests/support/certified.h"
#include "tests/support/engines.h"
#include "tests/support/packings.h"

using namespace packmesh;

namespace {

constexpr double degree = 0.017453292519943295;

std::vector<Pose> firstOf(const std::vector<Pose>& poses, std::size_t count) {
  return {poses.begin(), poses.begin() + std::ptrdiff_t(count)};
}

bool same(const Pose& a, const Pose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}

/// Both methods keep all constraints: nullptr is relaxation.
std::shared_ptr<const Engine> anyEngine() {
  return GENERATE(from_range(test::engines()));
}

/// Sweeps or iterations that it took.
std::int64_t effort(const PackingResult& result) {
  return result.statistics.effort();
}

}  // namespace

TEST_CASE("An axis is rotated into its cone by the smallest angle") {
  AxisCone cone{Vec3(1, 2, -2) / 3.0, 20.0 * degree};
  for (std::uint64_t i = 0; i < 200; ++i) {
    const auto u = uniform4(1, RandomStream::orientation, i, 0);
    const Quaternion q = uniformRotation(u[0], u[1], u[2]), r = cone.nearest(q);
    const double before = cone.angle(q), after = cone.angle(r);
    CHECK(before <= 90.0 * degree + 1e-12);
    CHECK(after == Approx(std::min(before, cone.spread)).margin(1e-12));
    CHECK(q.angularDistance(r) == Approx(std::max(0.0, before - cone.spread)).margin(1e-7));
    CHECK(cone.angle(q * Quaternion::around(Vec3::UnitX(), std::acos(-1.0))) == Approx(before));
  }
}

TEST_CASE("Fixed cells stay unchanged to the bit while others move") {
  const std::shared_ptr<const Engine> engine = anyEngine();
  for (const std::uint64_t seed : {1, 2, 3}) {
    PackingProblem problem = test::redCellProblem(test::periodicCube(25.0), 0.30, seed);
    const PackingResult first = test::packAll(problem);
    const std::size_t kept = 30;
    Species fixed = problem.physics.species[0], others = problem.physics.species[0];
    fixed.name = "stays";
    fixed.start = firstOf(first.poses, kept);
    fixed.count = kept;
    fixed.freedom.fixed = true;
    others.count = 45;
    problem.physics.species = {fixed, others};
    problem.engine = engine;
    const PackingResult result = test::packAll(problem);
    REQUIRE(result.cellCount == 75);
    for (std::size_t i = 0; i < kept; ++i) CHECK(same(result.poses[i], fixed.start[i]));
    CHECK(effort(result) > 0);
  }
}

TEST_CASE("Cells that do not fit beside fixed cells are omitted, fixed cells are not") {
  PackingProblem problem = test::redCellProblem(test::periodicCube(16.0), 0.40);
  const PackingResult first = test::packAll(problem);
  Species fixed = problem.physics.species[0], others = problem.physics.species[0];
  fixed.start = first.poses;
  fixed.freedom.fixed = true;
  others.count = 15;
  problem.physics.species = {fixed, others};
  problem.engine = anyEngine();
  problem.execution.limits.maxSweeps = 60;
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::outOfReach);
  REQUIRE(result.certificate.clean());
  REQUIRE(result.cellCount >= fixed.count);
  REQUIRE(result.cellCount < fixed.count + others.count);
  for (std::int64_t i = 0; i < fixed.count; ++i) CHECK(same(result.poses[i], fixed.start[i]));
}

TEST_CASE("One cell more than fits beside fixed cells is given up soon, and stays near the lumen") {
  PackingProblem problem = test::redCellProblem(makeCylinder(Vec3(15, 10, 10), 0, 10.0, 30.0, true), 0.45);
  const PackingResult first = test::packAll(problem);
  Species fixed = problem.physics.species[0], others = problem.physics.species[0];
  fixed.start = first.poses;
  fixed.freedom.fixed = true;
  others.count = 1;
  problem.physics.species = {fixed, others};
  double deepest = 0.0;
  problem.execution.progress = [&](const Progress& now) { deepest = std::max(deepest, now.worstOverlap); };
  const PackingResult result = pack(problem);
  CHECK(result.outcome == Outcome::outOfReach);
  CHECK(result.cellCount == fixed.count);
  CHECK(result.statistics.effort() < 10000);
  CHECK(deepest < 20.0);  // the width of the lumen
}

TEST_CASE("Fixed cells that meet each other or the wall are rejected") {
  PackingProblem problem = test::redCellProblem(test::periodicCube(16.0), 0.2);
  Species& species = problem.physics.species[0];
  species.name = "WBC";
  species.freedom.fixed = true;
  species.count = 2;
  species.start = {Pose{1.0, Quaternion::Identity(), Vec3(5, 5, 5)}};
  CHECK_THROWS_WITH(pack(problem), Contains("each of its cells needs an initial pose"));
  species.start.push_back(Pose{1.0, Quaternion::Identity(), Vec3(6, 5, 5)});
  CHECK_THROWS_WITH(pack(problem),
                    Contains("cell 1 of 'WBC' and cell 2 of 'WBC', which stay where they are, overlap"));
  species.start[1].position = Vec3(5, 14, 5);
  CHECK(pack(problem).cellCount == 2);
  problem.physics.container = makeSphere(Vec3(5, 5, 5), 10.0);
  CHECK_THROWS_WITH(pack(problem), Contains("cell 2 of 'WBC', which stays where it is,"));
  species.start[1].position.x() = std::nan("");
  CHECK_THROWS_AS(pack(problem), InputError);
}

TEST_CASE("A complete valid packing stays unchanged, and cells of an invalid one move") {
  PackingProblem problem = test::redCellProblem(test::periodicCube(20.0), 0.35, 4);
  const PackingResult first = test::packAll(problem);
  problem.engine = anyEngine();
  problem.physics.species[0].start = first.poses;
  const PackingResult again = test::packAll(problem);
  CHECK(effort(again) == 0);
  for (std::size_t i = 0; i < first.poses.size(); ++i) CHECK(same(again.poses[i], first.poses[i]));
  problem.physics.species[0].start[3].position = problem.physics.species[0].start[2].position;
  const PackingResult mended = test::packAll(problem);
  CHECK(effort(mended) > 0);
  // More cells: the first ones begin where they were, so most of them are not far from there.
  problem.physics.species[0].start = first.poses;
  problem.physics.species[0].count += 3;
  const PackingResult more = test::packAll(problem);
  int near = 0;
  for (std::size_t i = 0; i < first.poses.size(); ++i) {
    Vec3 d = more.poses[i].position - first.poses[i].position;
    for (int k = 0; k < 3; ++k) d[k] -= 20.0 * std::round(d[k] / 20.0);
    near += d.norm() < 4.0;
  }
  CHECK(2 * near > int(first.poses.size()));
}

TEST_CASE("Axes stay in their cone, centres in their region, cells away from the wall") {
  const std::shared_ptr<const Engine> engine = anyEngine();
  for (const std::uint64_t seed : {1, 2, 3}) {
    CAPTURE(seed);
    const auto lumen = std::shared_ptr<const Container>(makeCylinder(Vec3(15, 12, 12), 0, 12.0, 30.0, true));
    PackingProblem problem = test::redCellProblem(lumen, 0.1, seed);
    Species base = problem.physics.species[0];
    problem.physics.species.clear();
    const std::shared_ptr<const Container> half =
        makeBox({Vec3(0, 0, 0), Vec3(15, 24, 24)}, {false, false, false});
    const auto left = std::make_shared<BodyRegion>(half, lumen->bounds(), lumen->period());
    const auto right = std::make_shared<RegionDifference>(
        nullptr, std::vector<std::shared_ptr<const Region>>{left}, lumen->bounds());
    base.freedom.cone = AxisCone{Vec3(0, 0, 1), 30.0 * degree};
    base.freedom.extraWallClearance = 1.5;
    base.count = 24;
    base.freedom.region = left;
    problem.physics.species.push_back(base);
    base.count = 12;
    base.freedom.region = right;
    problem.physics.species.push_back(base);
    problem.engine = engine;
    const PackingResult result = test::packAll(problem);
    CHECK(result.certificate.minimumWallGap >= 1.5);
    for (std::size_t i = 0; i < result.poses.size(); ++i) {
      const Species& species = problem.physics.species[result.cells[i].species];
      CHECK(species.freedom.region->contains(result.poses[i].position));
      CHECK(species.freedom.cone->angle(result.poses[i].orientation) <= 30.0 * degree + 1e-9);
    }
    // A cone without spread: all alike.
    for (Species& species : problem.physics.species) species.freedom.cone->spread = 0.0;
    for (Species& species : problem.physics.species) species.count /= 2;
    const PackingResult aligned = test::packAll(problem);
    for (const Pose& pose : aligned.poses)
      CHECK(base.freedom.cone->angle(pose.orientation) <= 1e-9 + 30.0 * degree);
    for (const Pose& pose : aligned.poses)
      CHECK(AxisCone{Vec3(0, 0, 1), 0.0}.angle(pose.orientation) <= 1e-7);
  }
}

TEST_CASE("pack rejects invalid constraints of species") {
  const auto refused = [](auto&& change) {
    PackingProblem problem = test::redCellProblem(test::periodicCube(20.0), 0.1);
    change(problem);
    return test::messageOf<InputError>([&] { pack(problem); });
  };
  using P = PackingProblem;
  CHECK_THAT(refused([](P& p) { p.physics.species[0].freedom.extraWallClearance = -1.0; }),
             Contains("extra clearance"));
  CHECK_THAT(refused([](P& p) {
               p.physics.species[0].freedom.cone = AxisCone{Vec3(0, 0, 2), 0.1};
             }),
             Contains("not a unit vector"));
  CHECK_THAT(refused([](P& p) {
               p.physics.species[0].freedom.cone = AxisCone{Vec3(0, 0, 1), 2.0};
             }),
             Contains("pi/2"));
  CHECK_THAT(refused([](P& p) {
               p.physics.species[0].start = {Pose{0.5, Quaternion::Identity(), Vec3::Zero()}};
             }),
             Contains("not of full size"));
}

TEST_CASE("Membranes stay out of a free layer, and centres in their shell", "[profile]") {
  const auto pipe = std::shared_ptr<const Container>(makeCylinder(Vec3(15, 12, 12), 0, 12.0, 30.0, false));
  const auto wall = std::make_shared<const SideWall>(pipe, std::array<bool, 3>{true, false, false});
  const auto depth = std::make_shared<const SideDepth>(wall, pipe->bounds());
  for (const std::uint64_t seed : {1, 2, 3}) {
    CAPTURE(seed);
    PackingProblem problem = test::redCellProblem(pipe, 0.1, seed);
    Species base = problem.physics.species[0];
    problem.physics.species.clear();
    base.freedom.freeLayer = FreeLayer{wall, 2.0};
    for (const auto& [from, to, count] :
         {std::tuple(2.0, 5.0, 12), std::tuple(5.0, 8.0, 20), std::tuple(8.0, 20.0, 9)}) {
      base.count = count;
      base.freedom.region = std::make_shared<DepthShell>(depth, from, to);
      problem.physics.species.push_back(base);
    }
    const PackingResult result = test::packAll(problem);
    double nearest = 1e9, toEnd = 1e9;
    for (std::size_t i = 0; i < result.cells.size(); ++i) {
      const Species& species = problem.physics.species[result.cells[i].species];
      CHECK(species.freedom.region->distance(result.poses[i].position).distance > -0.01);
      for (const Vec3& v :
           placedVertices(problem.physics.shapeOf(species).mesh(), result.cells[i].placement)) {
        nearest = std::min(nearest, wall->distance(v).distance);
        toEnd = std::min({toEnd, v.x(), 30.0 - v.x()});
      }
    }
    CHECK(nearest > 1.99);
    CHECK(nearest < 2.5);
    CHECK(toEnd < 1.0);  // the layer is not along the ends
  }
}
