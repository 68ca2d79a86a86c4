// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/pack.h"

#include "packMesh/container/primitives.h"
#include "tests/support/catch.h"
#include "tests/support/packings.h"
#include "tests/support/physics.h"
#include "tests/support/vessels.h"
#if PACKMESH_CAT
#include "tests/support/cat.h"
#endif

using namespace packmesh;
using test::mixtureIn;

namespace {

struct Outline {
  Outcome outcome;
  std::int64_t effort, repairs, pairsTested, cells;
  double minimumGap, minimumWallGap;
  std::vector<double> numbers;  // of all cells, in order; on rank 0
};

using Examine = std::function<void(const PackingResult&)>;

Outline outlineOf(const PackingProblem& problem, const Examine& examine) {
  const PackingResult result = pack(problem);
  REQUIRE(result.certificate.clean());
  REQUIRE(result.certificate.cells == result.cellCount);
  examine(result);
  Outline outline{result.outcome,
                  result.statistics.effort(),
                  result.statistics.repairs,
                  result.certificate.pairsTested,
                  result.cellCount,
                  result.certificate.minimumGap,
                  result.certificate.minimumWallGap,
                  {}};
  std::vector<double> own;
  for (const Pose& pose : result.poses) {
    own.insert(own.end(), pose.position.data(), pose.position.data() + 3);
    own.insert(own.end(), pose.orientation.coeffs().data(), pose.orientation.coeffs().data() + 4);
  }
  outline.numbers = problem.execution.communicator.gatherAll(own);
  return outline;
}

/// Packs on all ranks, and on the first one alone, and compares.
void requireSameOnAllRanks(
    PackingProblem problem, const Examine& examine = [](const PackingResult&) {}) {
  const Communicator ranks = Communicator::world();
  problem.execution.communicator = ranks;
  const Outline shared = outlineOf(problem, examine);
  if (ranks.rank() != 0) return;
  problem.execution.communicator = Communicator();
  const Outline alone = outlineOf(problem, examine);
  REQUIRE(shared.outcome == alone.outcome);
  REQUIRE(shared.effort == alone.effort);
  REQUIRE(shared.repairs == alone.repairs);
  REQUIRE(shared.cells == alone.cells);
  REQUIRE(shared.pairsTested == alone.pairsTested);
  REQUIRE(shared.minimumGap == alone.minimumGap);
  REQUIRE(shared.minimumWallGap == alone.minimumWallGap);
  REQUIRE(shared.numbers == alone.numbers);
}

}  // namespace

TEST_CASE("The packing does not depend on the number of ranks", "[mpi]") {
  SECTION("periodic box of many blocks") {
    requireSameOnAllRanks(mixtureIn(makeBox({Vec3::Zero(), Vec3(110, 55, 28)}, {true, true, true}), 0.3, 1));
  }
  SECTION("box with walls, clearances") {
    PackingProblem problem =
        mixtureIn(makeBox({Vec3(1, 2, 3), Vec3(57, 58, 31)}, {true, false, false}), 0.3, 2);
    problem.physics.clearance = 0.1;
    problem.physics.wallClearance = 0.3;
    requireSameOnAllRanks(problem);
  }
  SECTION("cylinder with closed ends") {
    requireSameOnAllRanks(mixtureIn(makeCylinder(Vec3::Zero(), 0, 10.0, 80.0, false), 0.35, 3));
  }
  SECTION("sphere, where cells do not rotate") {
    PackingProblem problem = mixtureIn(makeSphere(Vec3::Zero(), 30.0), 0.15, 4);
    problem.physics.rotate = false;
    requireSameOnAllRanks(problem);
  }
  SECTION("repairs") {
    std::int64_t repairs = 0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed)
      requireSameOnAllRanks(
          mixtureIn(makeBox({Vec3::Zero(), Vec3(55, 26, 26)}, {true, true, true}), 0.55, seed),
          [&](const PackingResult& result) { repairs += result.statistics.repairs; });
    REQUIRE(repairs > 0);
  }
  SECTION("fewer cells than ranks") {
    PackingProblem problem = mixtureIn(makeSphere(Vec3::Zero(), 8.0), 0.0, 6);
    requireSameOnAllRanks(problem);
  }
}

TEST_CASE("Cells that are relocated are the same on any number of ranks", "[mpi]") {
  PackingProblem problem;
  problem.physics = test::physicsOf({test::redCellShape()}, test::twoChambers());
  problem.physics.species[0].count = 6;
  for (int i = 0; i < 6; ++i)
    problem.physics.species[0].start.push_back({1.0, Quaternion::Identity(), Vec3(7.0, 0.4 * i - 1.0, 0.0)});
  int left = 0;
  requireSameOnAllRanks(problem, [&](const PackingResult& result) {
    REQUIRE(result.outcome == Outcome::certified);
    for (const Pose& pose : result.poses) left += pose.position.x() < 0.0;
  });
  if (Communicator::world().alone()) REQUIRE(left > 0);
}

TEST_CASE("The densest packing of an infeasible request is the same on any number of ranks", "[mpi]") {
  PackingProblem problem = mixtureIn(makeBox({Vec3::Zero(), Vec3(55, 26, 26)}, {true, true, true}), 0.60, 7);
  problem.execution.limits.maxSweeps = 40;
  requireSameOnAllRanks(problem);
}

TEST_CASE("Without time for a sweep, the remaining cells are certified against the cells of all ranks",
          "[mpi]") {
  PackingProblem problem = mixtureIn(makeBox({Vec3::Zero(), Vec3(55, 55, 26)}, {true, true, true}), 0.4, 9);
  // The time is over at once, but never long over, however slow the machine.
  problem.execution.limits.clock = [now = 0.0]() mutable { return now += 1e-5; };
  problem.execution.limits.maxSeconds = 1e-9;
  requireSameOnAllRanks(problem);
}

TEST_CASE("All ranks save the same state of cells under repair", "[mpi]") {
  const Communicator world = Communicator::world();
  std::int64_t repairs = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    PackingProblem problem =
        mixtureIn(makeBox({Vec3::Zero(), Vec3(55, 26, 26)}, {true, true, true}), 0.55, seed);
    problem.execution.communicator = world;
    PackingState last;
    problem.checkpoints = Checkpoints{{}, [&](const PackingState& state) { last = state; }};
    repairs += pack(problem).statistics.repairs;
    const std::set<std::int64_t>& own = last.relaxation.disturbed;
    const auto all = world.gatherAll(std::vector<std::int64_t>(own.begin(), own.end()));
    REQUIRE(all.size() == own.size() * std::size_t(world.size()));
    for (std::size_t i = 0; i < all.size(); ++i) REQUIRE(own.count(all[i]) == 1);
  }
  REQUIRE(repairs > 0);
}

#if PACKMESH_CAT
TEST_CASE("Method cat gives the same packing on any number of ranks", "[mpi]") {
  SECTION("planes from chords") {
    PackingProblem problem =
        mixtureIn(makeBox({Vec3::Zero(), Vec3(30, 25, 25)}, {true, true, true}), 0.3, 10);
    test::useCat(problem);
    requireSameOnAllRanks(problem);
  }
  SECTION("at walls") {
    PackingProblem problem = mixtureIn(makeCylinder(Vec3::Zero(), 0, 8.0, 40.0, false), 0.2, 2);
    test::useCat(problem);
    problem.physics.wallClearance = 0.1;
    requireSameOnAllRanks(problem);
  }
  SECTION("barriers where cells are relaxed") {
    std::int64_t relaxations = 0;
    PackingProblem problem = mixtureIn(test::periodicCube(18.0), 0.5, 3);
    test::useCat(problem);
    requireSameOnAllRanks(problem, [&](const PackingResult& result) {
      relaxations += test::catStatistics(result).growth.relaxations;
    });
    REQUIRE(relaxations > 0);
  }
  SECTION("planes from CAT faces") {
    PackingProblem problem = mixtureIn(makeSphere(Vec3::Zero(), 8.0), 0.15, 4);
    test::useCat(problem).planeSource = PlaneSource::catFaces;
    requireSameOnAllRanks(problem);
  }
  SECTION("escaping") {
    std::int64_t changed = 0;
    PackingProblem problem = mixtureIn(makeSphere(Vec3::Zero(), 5.5), 0.59, 1);
    CatSettings& cat = test::useCat(problem);
    cat.escape.emplace();
    cat.growth.maxIterations = 12;
    cat.growth.attempts = 1;
    requireSameOnAllRanks(problem, [&](const PackingResult& result) {
      for (const EscapePhase& phase : test::catStatistics(result).escape) changed += phase.changed;
    });
    REQUIRE(changed > 0);
  }
}
#endif

TEST_CASE("An interruption of one rank ends all ranks", "[mpi]") {
  PackingProblem problem = mixtureIn(makeBox({Vec3::Zero(), Vec3(55, 55, 26)}, {true, true, true}), 0.5, 8);
  problem.execution.communicator = Communicator::world();
  int asked = 0;
  const bool last = problem.execution.communicator.rank() == problem.execution.communicator.size() - 1;
  problem.execution.interrupted = [&] { return last && ++asked > 3; };
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::interrupted);
  REQUIRE(result.cells.empty());
}

TEST_CASE("Calibration gives the same packing on any number of ranks", "[mpi]") {
  const PackingResult alone = pack(test::toBeCalibrated(42.0, 0.5, 0.99));
  const PackingResult together = pack(test::toBeCalibrated(42.0, 0.5, 0.99, Communicator::world()));
  REQUIRE(alone.statistics.repairs > 0);
  REQUIRE(together.statistics.repairs == alone.statistics.repairs);
  REQUIRE(together.statistics.sweeps == alone.statistics.sweeps);
  REQUIRE(together.certificate.minimumGap == alone.certificate.minimumGap);
}
