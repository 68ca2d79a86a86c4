// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/cell_placing.h"
#include "packMesh/container/region.h"
#include "packMesh/packing/pack.h"
#include "tests/support/catch.h"
#include "tests/support/packings.h"
#include "tests/support/physics.h"
#include "tests/support/vessels.h"

using namespace packmesh;

namespace {

/// Red cells that all begin in one of two chambers, which holds half of them.
PackingProblem crowded(std::int64_t count) {
  PackingProblem problem;
  problem.physics = test::physicsOf({test::redCellShape()}, test::twoChambers());
  problem.physics.species[0].count = count;
  for (std::int64_t i = 0; i < count; ++i)
    problem.physics.species[0].start.push_back(
        {1.0, Quaternion::Identity(), Vec3(7.0, 0.4 * double(i) - 1.0, 0.0)});
  return problem;
}

}  // namespace

TEST_CASE("A cell is put where there is most room", "[relocation]") {
  Physics physics = test::physicsOf({test::sphereShape(3.0)}, test::periodicCube(18.0));
  physics.species[0].count = 8;
  // Spheres of 3 µm on a cubic lattice of 9 µm with one vacancy: a gap of 3 µm there, of 1.8 µm elsewhere.
  std::vector<BodyState> cells;
  const Vec3 vacancy = Vec3::Constant(13.5);
  for (int i = 0; i < 7; ++i)
    cells.push_back(stateOf(
        i, 0, 0,
        {1.0, Quaternion::Identity(), 9.0 * Vec3(i & 1, i >> 1 & 1, i >> 2 & 1) + Vec3::Constant(4.5)}));
  cells.push_back(stateOf(7, 0, 0, {1.0, Quaternion::Identity(), Vec3(4.5, 5.0, 4.5)}));
  const std::vector<BodyState> before = cells;
  AccessibleSpaces spaces(physics, {});
  for (const std::int64_t round : {5, 6, 7}) {
    cells = before;
    CHECK(relocate(physics, {}, spaces, round, {7}, cells) == std::set<std::int64_t>{7});
    for (std::size_t i = 0; i < 7; ++i) CHECK(cells[i].position == before[i].position);
    CHECK(cells.back().id == 7);
    CHECK((cells.back().position - vacancy).norm() < 2.0);
    std::vector<BodyState> again = before;
    relocate(physics, {}, spaces, round, {7}, again);
    CHECK(again.back().position == cells.back().position);
  }
}

TEST_CASE("Where there is no room, no cell is put", "[relocation]") {
  Physics physics = test::physicsOf({test::redCellShape()}, makeSphere(Vec3::Zero(), 3.0));
  physics.species[0].count = 1;
  std::vector<BodyState> cells = {stateOf(0, 0, 0, {1.0, Quaternion::Identity(), Vec3::Zero()})};
  AccessibleSpaces spaces(physics, {});
  CHECK(relocate(physics, {}, spaces, 1, {0}, cells).empty());
  CHECK(cells.back().position == Vec3::Zero());
}

TEST_CASE("Cells that all begin in one chamber are packed in both", "[relocation]") {
  for (const std::uint64_t seed : {1, 2, 3}) {
    PackingProblem problem = crowded(6);
    problem.physics.seed = seed;
    const PackingResult result = pack(problem);
    CAPTURE(seed);
    CHECK(result.outcome == Outcome::certified);
    CHECK(result.certificate.clean());
    int left = 0;
    for (const Pose& pose : result.poses) left += pose.position.x() < 0.0;
    CHECK(left >= 2);
  }
}

TEST_CASE("One cell more among many fixed ones is tried in the largest rooms", "[relocation]") {
  PackingProblem problem = test::redCellProblem(test::periodicCube(26.0), 0.40);
  const PackingResult first = pack(problem);
  REQUIRE(first.outcome == Outcome::certified);
  std::vector<Pose> fixed = first.poses;
  // Every cell in turn is the free one: there is room where it was.
  for (const std::size_t left : {std::size_t(0), fixed.size() / 2}) {
    PackingProblem last = problem;
    Species still = problem.physics.species[0], free = still;
    still.start = fixed;
    still.start.erase(still.start.begin() + std::ptrdiff_t(left));
    still.count = std::int64_t(still.start.size());
    still.freedom.fixed = true;
    free.count = 1;
    last.physics.species = {still, free};
    last.execution.limits.fewerCells = false;
    CHECK(pack(last).outcome == Outcome::certified);
  }
}

TEST_CASE("A few cells may keep less than the clearances where that is permitted", "[relocation]") {
  // A wide chamber, and one in which a cell fits, but not with the clearance.
  const auto radius = [](double x) {
    const double wide = 144.0 - x * x, narrow = 4.8 * 4.8 - (x - 16.0) * (x - 16.0);
    return std::sqrt(std::max({0.64, wide, narrow}));
  };
  PackingProblem problem;
  problem.physics =
      test::physicsOf({test::redCellShape()},
                      makeVessel(sample::tube(
                                     -11.5, 20.0, 120, 48, [](double) { return Vec3::Zero(); }, radius),
                                 {}, 0.25));
  problem.physics.species[0].count = 20;
  Species alone = problem.physics.species[0];
  alone.count = 1;
  alone.start = {{1.0, Quaternion::Identity(), Vec3(16.0, 0.0, 0.0)}};
  const Box bounds = problem.physics.container->bounds();
  alone.freedom.region = std::make_shared<BodyRegion>(
      makeBox({Vec3(15, -5, -5), Vec3(17, 5, 5)}, {false, false, false}), bounds, Vec3::Zero());
  problem.physics.species.push_back(alone);
  problem.physics.wallClearance = 1.2;
  problem.execution.limits.maxSweeps = 600;
  problem.execution.limits.fewerCells = false;
  CHECK(pack(problem).outcome == Outcome::outOfReach);
  problem.execution.limits.someCloser = true;
  const PackingResult result = pack(problem);
  CHECK(result.outcome == Outcome::certified);
  CHECK(result.certificate.clean());
  CHECK(result.certificate.closer == 1);
  CHECK(result.certificate.minimumWallGap > 0.0);
  CHECK(result.certificate.minimumWallGap < 1.2);
}

TEST_CASE("What is packed with one seed is packed with every seed, and so is less of it",
          "[relocation][long]") {
  const auto tapered = [](double length, auto radius) {
    return makeVessel(sample::tube(
                          0.0, length, 61, 32, [](double) { return Vec3::Zero(); }, radius),
                      {}, 0.25);
  };
  const std::vector<std::pair<const char*, std::shared_ptr<const Container>>> lumens = {
      {"chambers", test::twoChambers()},
      {"tapered", tapered(40.0, [](double x) { return 7.0 - 4.5 * x / 40.0; })},
      {"throat",
       tapered(40.0, [](double x) { return 6.0 - 3.5 * std::exp(-std::pow((x - 20.0) / 6.0, 2)); })}};
  const std::vector<std::uint64_t> seeds = {1, 2, 3};
  for (const auto& [name, lumen] : lumens) {
    PackingProblem problem;
    problem.physics = test::physicsOf({test::redCellShape()}, lumen);
    problem.physics.clearance = 0.05;
    problem.physics.wallClearance = 0.25;
    problem.execution.limits.maxSweeps = 20000;
    const auto packs = [&](std::int64_t cells, std::uint64_t seed) {
      problem.physics.species[0].count = cells;
      problem.physics.seed = seed;
      const PackingResult result = pack(problem);
      return result.outcome == Outcome::certified;
    };
    const double one = test::redCellShape()->volume();
    std::vector<std::pair<std::int64_t, std::int64_t>> packed;  // cells, seeds that pack them
    for (const double hematocrit : {0.10, 0.20, 0.25, 0.30, 0.35}) {
      const auto cells = std::int64_t(hematocrit * lumen->volume() / one);
      packed.emplace_back(cells, std::count_if(seeds.begin(), seeds.end(),
                                               [&](std::uint64_t seed) { return packs(cells, seed); }));
    }
    CAPTURE(name, packed);
    CHECK(packed.front().second == std::int64_t(seeds.size()));
    for (std::size_t i = 1; i < packed.size(); ++i)
      if (packed[i].second > 0) CHECK(packed[i - 1].second == std::int64_t(seeds.size()));
  }
}
