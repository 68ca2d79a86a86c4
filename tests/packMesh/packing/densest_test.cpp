// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/densest.h"

#include "packMesh/packing/attempt.h"
#include "tests/support/catch.h"
#include "tests/support/deformed.h"
#include "tests/support/packings.h"

using namespace packmesh;
using test::mixtureIn;
using test::periodicCube;
using test::redCellProblem;

namespace {

std::vector<std::int64_t> countsOf(const PackingProblem& problem, const PackingResult& result) {
  std::vector<std::int64_t> counts(problem.physics.species.size(), 0);
  for (const PlacedCell& cell : result.cells) ++counts[cell.species];
  return counts;
}

/// A single attempt at all cells.
PackingResult attempt(const PackingProblem& problem) {
  RunControl control(problem);
  Attempt once(problem, control);
  once.certifyAll();
  return once.takeResult();
}

/// Every look at the clock takes a tenth of a second.
struct SlowClock {
  double now = 0.0;
  double operator()() { return now += 0.1; }
};

/// A second is so many sweeps; nothing else takes time.
PackingResult packedWith(PackingProblem problem, double sweepsPerSecond, double seconds) {
  double now = 0.0;
  problem.execution.progress = [&](const Progress&) { now += 1.0 / sweepsPerSecond; };
  problem.execution.limits.clock = [&] { return now; };
  problem.execution.limits.maxSeconds = seconds;
  return pack(problem);
}

/// As many red cells as a hematocrit asks for, and platelets by a ratio.
PackingProblem withPlatelets(const std::shared_ptr<const Container>& lumen, double hematocrit) {
  constexpr double ratio = 0.07;
  const double red = std::round(hematocrit * lumen->volume() / test::redCellShape()->volume());
  PackingProblem problem;
  problem.physics.container = lumen;
  problem.physics.add("RBC", test::redCellShape(), std::llround(red));
  problem.physics.add("PLT", test::sphereShape(1.0), std::llround(ratio * red)).inHematocrit = false;
  problem.physics.species[1].asked = ratio * red;
  return problem;
}

}  // namespace

TEST_CASE("A larger request gives no less in the same time", "[densest][long]") {
  const auto lumen = periodicCube(20.0);
  const double seconds = GENERATE(5.0, 15.0);
  CAPTURE(seconds);
  std::vector<std::int64_t> before(2, 0);
  for (const double hematocrit : {0.56, 0.60, 0.62, 0.65, 0.80}) {
    const PackingProblem problem = withPlatelets(lumen, hematocrit);
    const PackingResult result = packedWith(problem, 100.0, seconds);
    const std::vector<std::int64_t> counts = countsOf(problem, result);
    CAPTURE(hematocrit, counts, before);
    REQUIRE(result.certificate.clean());
    for (std::size_t s = 0; s < counts.size(); ++s) CHECK(counts[s] >= before[s]);
    before = counts;
  }
}

TEST_CASE("A problem packed at once gives the same result with and without a time limit", "[densest]") {
  const PackingProblem problem = redCellProblem(periodicCube(20.0), 0.56);
  const PackingResult free = pack(problem), limited = packedWith(problem, 100.0, 50.0);
  REQUIRE(free.outcome == Outcome::certified);
  REQUIRE(test::sameBits(limited, free));
  REQUIRE(limited.statistics.effort() == free.statistics.effort());
}

TEST_CASE("Cells that take long are packed as without a time limit", "[densest]") {
  const PackingProblem problem = redCellProblem(periodicCube(25.0), 0.6);
  const PackingResult free = pack(problem), limited = packedWith(problem, 100.0, 50.0);
  REQUIRE(free.outcome == Outcome::certified);
  REQUIRE(free.statistics.effort() > 300);  // not at once
  REQUIRE(limited.outcome == Outcome::certified);
  REQUIRE(test::sameBits(limited, free));
}

TEST_CASE("A larger request gives the same densest packing", "[densest][long]") {
  std::vector<PackingResult> results;
  for (const double fraction : {0.66, 0.9}) {
    results.push_back(pack(redCellProblem(periodicCube(16.0), fraction)));
    REQUIRE(results.back().outcome == Outcome::outOfReach);
    REQUIRE(results.back().searched);
    REQUIRE(results.back().certificate.clean());
    REQUIRE(test::sameBits(results.back(), results.front()));
  }
  REQUIRE(results.front().certificate.cellVolume > 0.54 * 16.0 * 16.0 * 16.0);
}

TEST_CASE("The densest packing beside a thick wall layer is found", "[densest][long]") {
  PackingProblem problem = redCellProblem(makeCylinder(Vec3::Zero(), 0, 9.0, 30.0, true), 0.5);
  problem.physics.species[0].freedom.extraWallClearance = 3.5;
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::outOfReach);
  REQUIRE(result.searched);
  // As many as any packing by itself, tried with all there is.
  PackingProblem more = problem;
  more.physics.species[0].count = result.cellCount + 1 + result.cellCount / 20;
  more.execution.limits.maxSweeps = 2300;
  CHECK(attempt(more).outcome == Outcome::outOfReach);
  more.physics.species[0].count = result.cellCount;
  CHECK(attempt(more).outcome == Outcome::certified);
}

TEST_CASE("Fewer cells keep the shares of their species", "[densest][long]") {
  const PackingProblem problem = mixtureIn(periodicCube(16.0), 0.75, 4);
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::outOfReach);
  const std::vector<std::int64_t> counts = countsOf(problem, result);
  const double share = double(counts[0]) / double(problem.physics.species[0].count);
  REQUIRE(share > 0.7);
  REQUIRE(std::abs(double(counts[1]) - share * double(problem.physics.species[1].count)) <= 1.0);
}

TEST_CASE("The densest packing of deformed cells has about as many as one of others",
          "[densest][shapes][long]") {
  constexpr double edge = 5.0;
  const test::ShapePointer platelet = test::hemocellShape("PLT");
  PackingProblem problem;
  Physics& physics = problem.physics;
  physics.container = periodicCube(edge);
  physics.add("PLT", platelet, std::int64_t(0.85 * edge * edge * edge / platelet->volume()));
  for (int n = 0; n < int(physics.species[0].count); ++n) {
    physics.shapes.push_back(std::make_shared<const Shape>(test::deformed(platelet->mesh(), n), platelet));
    physics.species[0].deformed.push_back({n + 1, {}});
  }
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::outOfReach);
  REQUIRE(result.searched);
  REQUIRE(result.certificate.clean());
  CHECK(result.certificate.cellVolume > 0.6 * edge * edge * edge);
  for (std::size_t i = 0; i < result.cells.size(); ++i) CHECK(result.cells[i].shape == int(i) + 1);
}

TEST_CASE("An attempt gives all cells or none", "[densest]") {
  const PackingResult all = attempt(redCellProblem(periodicCube(20.0), 0.4));
  REQUIRE(all.outcome == Outcome::certified);
  REQUIRE(all.certificate.clean());
  const PackingResult none = attempt(redCellProblem(periodicCube(20.0), 0.8));
  REQUIRE(none.outcome == Outcome::outOfReach);
  REQUIRE(none.cells.empty());
  REQUIRE(none.cellCount == 0);
  REQUIRE(none.statistics.effort() == 300);  // jammed
}

TEST_CASE("A time limit ends attempt and search, and the result is not reported as the densest",
          "[densest]") {
  PackingProblem problem = redCellProblem(periodicCube(25.0), 0.62);
  SlowClock clock;
  problem.execution.limits.clock = [&] { return clock(); };
  problem.execution.limits.maxSeconds = 20.0;  // 200 looks
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::outOfReach);
  REQUIRE_FALSE(result.searched);
  REQUIRE(result.certificate.clean());
  REQUIRE(result.cellCount > 0);
  // As promised: twice the limit and 5 s.
  REQUIRE(clock.now < 2.0 * problem.execution.limits.maxSeconds + 5.0);
}

TEST_CASE("A run without time to certify ends without cells", "[densest]") {
  PackingProblem problem = redCellProblem(periodicCube(60.0), 0.4);  // more cells than looks at the clock
  SlowClock clock;
  problem.execution.limits.clock = [&] { return clock(); };
  problem.execution.limits.maxSeconds = 1e-9;
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::outOfReach);
  REQUIRE(result.cellCount == 0);
  REQUIRE(result.cells.empty());
  REQUIRE(clock.now < 5.0);
}
