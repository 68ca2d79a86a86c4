// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/pack.h"
#include "packMesh/container/obstacles.h"
#include "packMesh/container/vessel.h"
#include "packMesh/core/error.h"
#include "packMesh/relaxation/contact_kernels.h"
#include "tests/support/catch.h"
#include "tests/support/certified.h"
#include "tests/support/packings.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;
using test::periodicCube;
using test::redCellProblem;

TEST_CASE("Invalid problems are rejected with a reason", "[packing]") {
  const PackingProblem valid = redCellProblem(periodicCube(25.0), 0.40);
  REQUIRE_NOTHROW(validate(valid));
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                   infinite = std::numeric_limits<double>::infinity();
  const auto refused = [&](auto&& change, const std::string& message) {
    PackingProblem problem = valid;
    change(problem.physics);
    CAPTURE(message);
    CHECK_THROWS_WITH(validate(problem), Contains(message));
  };
  refused([](Physics& p) { p.container = nullptr; }, "no container");
  refused(
      [](Physics& p) {
        p.container = makeBox({Vec3::Zero(), Vec3(0.2, 100.0, 100.0)}, {true, true, true});
      },
      "the period of the lumen, 0.2 µm along x, is too small");
  refused([](Physics& p) { p.shapes[0] = nullptr; }, "species 'RBC' has no shape");
  refused([](Physics& p) { p.species[0].count = -3; }, "species 'RBC' has a negative count, -3");
  refused([](Physics& p) { p.clearance = -0.1; }, "found -0.1");
  for (const double clearance : {-0.1, nan})
    refused([&](Physics& p) { p.clearance = clearance; }, "clearance between cells");
  for (const double clearance : {infinite, -1e-9})
    refused([&](Physics& p) { p.wallClearance = clearance; }, "clearance to the wall");
  const auto tooMany = [](Physics& p) { p.species[0].count = 250; };
  refused(tooMany, "more volume than the lumen");
  PackingProblem problem = valid;
  tooMany(problem.physics);
  REQUIRE_THROWS_AS(pack(problem), InputError);
  problem.physics.species[0].count = 1;
  problem.physics.container = makeCylinder(Vec3::Zero(), 0, 0.5, 200.0, true);
  REQUIRE_THROWS_WITH(validate(problem),
                      Contains("species 'RBC'") && Contains("larger than the lumen") && Contains("cylinder"));
  problem.physics.container = makeBox(Box{Vec3::Zero(), Vec3(4.0, 30.0, 30.0)}, {false, true, true});
  REQUIRE_NOTHROW(validate(problem));
  problem.physics.wallClearance = 1.9;
  REQUIRE_THROWS_WITH(validate(problem), Contains("larger than the lumen"));
  // Species that are not wanted may be of any size.
  problem.physics.container = periodicCube(8.0);
  problem.physics.add("rock", test::sphereShape(50.0), 0);
  REQUIRE_NOTHROW(validate(problem));
}

TEST_CASE("cellVolume includes the cells of all species", "[packing]") {
  PackingProblem problem = redCellProblem(periodicCube(25.0), 0.40);
  const auto sphere = test::sphereShape(1.0);
  problem.physics.add("sphere", sphere, 7);
  REQUIRE(cellVolume(problem) ==
          Approx(problem.physics.species[0].count * test::redCellShape()->volume() + 7.0 * sphere->volume()));
}

using test::periodicCube;
using test::redCellProblem;

TEST_CASE("Red cells are packed without overlap for any seed", "[packing]") {
  for (const double fraction : {0.35, 0.45})
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      CAPTURE(fraction, seed);
      const PackingProblem problem = redCellProblem(periodicCube(25.0), fraction, seed);
      const PackingResult result = test::packAll(problem);
      REQUIRE(result.statistics.sweeps > 0);
    }
}

TEST_CASE("Species that share a shape have numbers of cells of their own", "[packing]") {
  PackingProblem problem = redCellProblem(periodicCube(25.0), 0.2, 3);
  Species others = problem.physics.species[0];
  others.name = "RBC, others";
  others.count = 5;
  problem.physics.species.push_back(others);
  const PackingResult result = test::packAll(problem);
  CHECK(result.counts == std::vector<std::int64_t>{problem.physics.species[0].count, 5});
  CHECK(std::all_of(result.cells.begin(), result.cells.end(),
                    [](const PlacedCell& c) { return c.shape == 0; }));
}

TEST_CASE("The packing has the same bits on any number of threads", "[packing][threads]") {
  const TriangleMesh tube = sample::tube(
      0.0, 80.0, 81, 16, [](double x) { return Vec3(x, 2.0 * std::sin(2.0 * M_PI * x / 80.0), 0.0); },
      [](double) { return 9.0; });
  const std::vector<std::pair<std::shared_ptr<const Container>, double>> lumens = {
      {periodicCube(60.0), 0.45},
      {makeBox(Box{Vec3(0, 0, 0), Vec3(90, 60, 22)}, {true, false, false}), 0.35},
      {makeVessel(tube, VesselEnds{0, 0.0, 80.0, true}, 0.5), 0.30}};
  for (const auto& [lumen, fraction] : lumens) {
    CAPTURE(lumen->describe());
    PackingProblem problem = redCellProblem(lumen, fraction, 5);
    const PackingResult alone = pack(problem);
    REQUIRE(alone.outcome == Outcome::certified);
    REQUIRE(alone.statistics.blocks > 1);
    for (const int threads : {2, 5}) {
      problem.execution.threads = Threads(threads);
      const PackingResult together = pack(problem);
      REQUIRE(test::sameBits(together, alone));
      REQUIRE(together.certificate.pairsTested == alone.certificate.pairsTested);
      REQUIRE(together.certificate.minimumWallGap == alone.certificate.minimumWallGap);
    }
  }
}

TEST_CASE("All instruction sets give the same packing", "[packing]") {
  std::vector<PackingResult> results;
  for (const auto& [name, set] :
       {std::make_pair("portable", InstructionSet::portable), std::make_pair("avx2", InstructionSet::avx2),
        std::make_pair("avx512", InstructionSet::avx512)}) {
    if (!available(set)) {
      WARN("This processor lacks " << name);
      continue;
    }
    const test::Variable isa("PACKMESH_ISA", name);
    REQUIRE(chosenInstructionSet() == set);
    results.push_back(pack(redCellProblem(periodicCube(25.0), 0.45, 3)));
  }
  for (const PackingResult& result : results) {
    REQUIRE(test::sameBits(result, results[0]));
    REQUIRE(result.statistics.sweeps == results[0].statistics.sweeps);
  }
}

TEST_CASE("Mixtures are packed in the order of the species", "[packing]") {
  const auto platelet = test::hemocellShape("PLT"), white = test::hemocellShape("WBC");
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    PackingProblem problem = redCellProblem(periodicCube(25.0), 0.35, seed);
    problem.physics.add("PLT", platelet, 8);
    problem.physics.add("WBC", white, 1);
    test::packAll(problem);
  }
}

TEST_CASE("General meshes are packed", "[packing]") {
  PackingProblem problem = redCellProblem(periodicCube(20.0), 0.15, 1);
  problem.physics.add("bumpy", std::make_shared<const Shape>(test::bumpyMesh(5)), 20);
  problem.physics.add("hook", std::make_shared<const Shape>(test::hookMesh()), 10);
  test::packAll(problem);
}

TEST_CASE("Thin cells do not remain interpenetrated", "[packing]") {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    CAPTURE(seed);
    PackingProblem problem;
    problem.physics.add("plate", hemocell::makeEllipsoid(6.0, 0.3, 6.0), 50);
    problem.physics.container = periodicCube(15.0);
    problem.physics.seed = seed;
    problem.execution.limits.maxSweeps = 2000;
    test::packAll(problem);
  }
}

TEST_CASE("Walls confine the cells", "[packing]") {
  const TriangleMesh tube = sample::tube(
      0.0, 30.0, 31, 16, [](double x) { return Vec3(x, 2.0 * std::sin(2.0 * M_PI * x / 30.0), 0.0); },
      [](double) { return 9.0; });
  std::vector<std::shared_ptr<const Container>> containers = {
      makeBox(Box{Vec3(0, 0, 0), Vec3(25, 20, 22)}, {true, false, false}),
      makeBox(Box{Vec3(0, 0, 0), Vec3(25, 20, 22)}, {false, false, false}),
      makeCylinder(Vec3(12.5, 13, 13), 0, 10.0, 25.0, true),
      makeCylinder(Vec3(12.5, 13, 13), 1, 10.0, 25.0, false),
      makeSphere(Vec3(0, 0, 0), 11.0),
      makeVessel(tube, VesselEnds{0, 0.0, 30.0, true}, 0.5),
      makeVessel(tube, VesselEnds{0, -1.0, 31.0, false}, 0.5),
      makeVessel(sample::sphere({0, 0, 0}, 11.0, 16, 24), std::nullopt, 0.5),
      subtractObstacles(makeBox(Box{Vec3(0, 0, 0), Vec3(25, 25, 25)}, {true, true, false}),
                        {{sample::box({8, 8, 8}, {13, 14, 15}), "block"}})};
  for (const auto& container : containers) {
    for (const double wallClearance : {0.1, 0.5}) {
      CAPTURE(container->describe(), wallClearance);
      PackingProblem problem = redCellProblem(container, wallClearance < 0.3 ? 0.30 : 0.20);
      problem.physics.wallClearance = wallClearance;
      const PackingResult result = test::packAll(problem);
      // Cells are as near as they may be: the clearance is what keeps them away.
      REQUIRE(result.certificate.minimumWallGap < wallClearance + 0.2);
    }
  }
}

TEST_CASE("Without rotation every orientation stays the identity", "[packing]") {
  PackingProblem problem = redCellProblem(periodicCube(25.0), 0.30);
  problem.physics.rotate = false;
  const PackingResult result = test::packAll(problem);
  for (const PlacedCell& cell : result.cells) REQUIRE(cell.placement.linear == Mat3::Identity());
}

TEST_CASE("The requested clearance is kept", "[packing]") {
  for (const double clearance : {0.1, 0.25}) {
    CAPTURE(clearance);
    PackingProblem problem = redCellProblem(periodicCube(25.0), 0.35);
    problem.physics.clearance = clearance;
    const PackingResult result = test::packAll(problem);
    REQUIRE(result.certificate.minimumGap >= clearance);
    REQUIRE(result.certificate.minimumGap < clearance + 0.1);
  }
}

TEST_CASE("Cells can meet their own images", "[packing]") {
  // The period is hardly more than the cell's diameter of 7.82 µm.
  PackingProblem problem = redCellProblem(periodicCube(8.0), 0.32);
  REQUIRE(problem.physics.species[0].count == 2);
  problem.execution.limits.maxSweeps = 3000;
  test::packAll(problem);
}

TEST_CASE("Cells begin clear of their own images, so that a thin box is packed with any seed", "[packing]") {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    CAPTURE(seed);
    const PackingProblem problem =
        test::redCellProblem(makeBox({Vec3::Zero(), Vec3(30, 30, 4)}, {true, true, true}), 0.5, seed);
    REQUIRE(pack(problem).outcome == Outcome::certified);
  }
}

TEST_CASE("A limit of sweeps can be extended for the last few contacts", "[packing][long]") {
  // With this seed two thin parts remain interpenetrated for long.
  hemocell::CellModel coarse = *hemocell::defaultModel("RBC");
  coarse.minNumTriangles = 300;
  PackingProblem problem = redCellProblem(periodicCube(80.0), 0.45);
  problem.physics.shapes[0] = hemocell::makeShape(coarse, 1.0);
  problem.physics.clearance = 0.15;
  problem.physics.seed = 5;
  const PackingResult unlimited = pack(problem);
  REQUIRE(unlimited.outcome == Outcome::certified);
  problem.execution.limits.fewerCells = false;
  problem.execution.limits.maxSweeps = 50;
  REQUIRE(unlimited.statistics.sweeps > problem.execution.limits.maxSweeps);
  CHECK(pack(problem).outcome == Outcome::outOfReach);
  problem.execution.limits.sweepsForFew = 100;
  CHECK(test::sameBits(pack(problem), unlimited));
  problem.execution.limits.maxSweeps = 3;  // there are still many contacts
  CHECK(pack(problem).outcome == Outcome::outOfReach);
}

TEST_CASE("An infeasible request ends with fewer cells and a clean certificate", "[packing]") {
  PackingProblem problem = redCellProblem(periodicCube(16.0), 0.75);
  problem.execution.limits.maxSweeps = 600;
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::outOfReach);
  REQUIRE(std::int64_t(result.cells.size()) < problem.physics.species[0].count);
  REQUIRE(result.certificate.cellVolume > 0.45 * problem.physics.container->volume());
  test::requireValid(problem, result);
  REQUIRE(test::sameBits(pack(problem), result));
}

TEST_CASE("A time limit ends a run with the cells packed so far", "[packing]") {
  PackingProblem problem = redCellProblem(periodicCube(16.0), 0.70);
  problem.execution.limits.maxSeconds = 0.05;
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::outOfReach);
  REQUIRE(std::int64_t(result.cells.size()) < problem.physics.species[0].count);
  test::requireValid(problem, result);
}

TEST_CASE("A short time limit still gives some cells", "[packing]") {
  for (const double clearance : {0.0, 0.3}) {
    PackingProblem problem = redCellProblem(periodicCube(30.0), 0.50);
    // The time is over at once, but never long over, however slow the machine.
    problem.execution.limits.clock = [now = 0.0]() mutable { return now += 1e-5; };
    problem.execution.limits.maxSeconds = 1e-6;
    problem.physics.clearance = clearance;
    const PackingResult result = pack(problem);
    REQUIRE(result.outcome == Outcome::outOfReach);
    REQUIRE(result.cells.size() > 10);
    test::requireValid(problem, result);
  }
}

TEST_CASE("Cells that approximate wall distances let too close to the wall get extra clearance",
          "[packing]") {
  /// A wall that seems to be further away than it is.
  class Optimistic : public Wall {
   public:
    Optimistic(std::shared_ptr<const Container> of, double error) : of_(std::move(of)), error_(error) {}
    WallDistance distance(const Vec3& p) const override {
      WallDistance found = of_->wall()->distance(p);
      found.distance += error_;
      return found;
    }
    double slack() const override { return error_; }
    WallVerdict examine(const PlacedHierarchy& cell, double gapOfInterest) const override {
      return of_->wall()->examine(cell, gapOfInterest);
    }

   private:
    std::shared_ptr<const Container> of_;
    double error_;
  };
  for (const auto& [clearance, layer] : {std::pair(0.0, 0.0), {0.3, 0.0}, {0.0, 0.3}}) {
    CAPTURE(clearance, layer);
    const std::shared_ptr<const Container> cylinder = makeCylinder(Vec3::Zero(), 0, 9.0, 30.0, false);
    PackingProblem problem = redCellProblem(cylinder, 0.35);
    problem.physics.wallClearance = clearance;
    problem.physics.species[0].freedom.extraWallClearance = layer;
    problem.physics.species[0].wall = std::make_shared<Optimistic>(cylinder, 0.05);
    const PackingResult result = pack(problem);
    REQUIRE(result.outcome == Outcome::certified);
    REQUIRE(result.statistics.repairs > 0);
    REQUIRE(result.certificate.minimumWallGap >= clearance + layer);
    problem.physics.species[0].wall = nullptr;
    test::requireValid(problem, result);
  }
}

TEST_CASE("An interrupted run gives no cells", "[packing]") {
  PackingProblem problem = redCellProblem(periodicCube(20.0), 0.60);
  int polls = 0;
  problem.execution.interrupted = [&] { return ++polls > 5; };
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::interrupted);
  REQUIRE(result.cells.empty());
  REQUIRE(result.poses.empty());
  REQUIRE(result.statistics.sweeps < 10);
}

TEST_CASE("pack() reports its progress", "[packing]") {
  PackingProblem problem = redCellProblem(periodicCube(25.0), 0.40);
  std::vector<Progress> told;
  problem.execution.progress = [&](const Progress& p) { told.push_back(p); };
  const PackingResult result = pack(problem);
  REQUIRE(std::int64_t(told.size()) == result.statistics.sweeps);
  for (std::size_t k = 0; k < told.size(); ++k) REQUIRE(told[k].sweep == std::int64_t(k) + 1);
  REQUIRE(told.front().stage == "relaxation");
  REQUIRE(told.front().unresolved > 100);
  REQUIRE(told.front().worstOverlap > told.back().worstOverlap);
}

TEST_CASE("The certificate applies to the numbers that are written", "[packing]") {
  PackingProblem problem = redCellProblem(periodicCube(25.0), 0.40);
  problem.physics.written = [](const Pose& pose) {  // coarse numbers
    Placement placement = pose.placement();
    placement.translation = (placement.translation * 100.0).array().round() / 100.0;
    return placement;
  };
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::certified);
  REQUIRE(result.certificate.clean());
  for (std::size_t i = 0; i < result.cells.size(); ++i)
    REQUIRE(result.cells[i].placement.translation == problem.physics.written(result.poses[i]).translation);
}

TEST_CASE("Empty and single-cell problems are packed", "[packing]") {
  PackingProblem problem = redCellProblem(periodicCube(25.0), 0.0);
  REQUIRE(pack(problem).outcome == Outcome::certified);
  problem.physics.species.clear();
  REQUIRE(pack(problem).outcome == Outcome::certified);
  problem = redCellProblem(periodicCube(25.0), 0.006);
  REQUIRE(problem.physics.species[0].count == 1);
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::certified);
  REQUIRE(result.cells.size() == 1);
}
