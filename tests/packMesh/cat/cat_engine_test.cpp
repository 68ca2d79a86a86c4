// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/cat_engine.h"

#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/certified.h"

using namespace packmesh;

namespace {

PackingProblem grown(std::shared_ptr<const Container> container, double fraction) {
  PackingProblem problem = test::redCellProblem(std::move(container), fraction);
  test::useCat(problem);
  return problem;
}

}  // namespace

TEST_CASE("Method cat packs boxes, cylinders, spheres and vessels, periodic and closed") {
  const TriangleMesh tube = sample::straightTube(0.0, 24.0, 9.0, 9, 48);
  const std::vector<std::shared_ptr<const Container>> containers = {
      test::periodicCube(16.0),
      makeBox(Box{Vec3::Zero(), Vec3(14.0, 18.0, 16.0)}, {false, true, false}),
      makeCylinder(Vec3(12.0, 0.0, 0.0), 0, 9.0, 24.0, true),
      makeSphere(Vec3::Zero(), 11.0),
      makeVessel(tube, VesselEnds{0, 0.0, 24.0, true}, 0.25),
      makeVessel(tube, VesselEnds{0, 0.0, 24.0, false}, 0.25)};
  for (const auto& container : containers) {
    CAPTURE(container->describe());
    const PackingProblem problem = grown(container, 0.35);
    const PackingResult result = test::packAll(problem);
    REQUIRE(result.statistics.engine);
    CHECK(result.statistics.engine->iterations() > 0);
    CHECK(result.statistics.engineSeconds > 0.0);
  }
}

TEST_CASE("Method cat packs mixtures, with clearances, and without rotation") {
  PackingProblem problem = grown(test::periodicCube(18.0), 0.25);
  problem.physics.add("PLT", test::hemocellShape("PLT"), 12);
  problem.physics.add("WBC", test::hemocellShape("WBC"), 1);
  problem.physics.clearance = 0.1;
  const PackingResult result = test::packAll(problem);
  CHECK(result.certificate.minimumGap >= 0.1);
  problem.physics.clearance = 0.0;
  problem.physics.rotate = false;
  const PackingResult still = test::packAll(problem);
  for (const Pose& pose : still.poses) CHECK(pose.orientation.coeffs() == Quaternion::Identity().coeffs());
}

TEST_CASE("Method cat packs with planes from tetrahedra") {
  const std::pair<std::shared_ptr<const Container>, double> lumens[] = {
      {test::periodicCube(10.0), 0.3}, {makeSphere(Vec3::Zero(), 6.5), 0.25}};
  for (const auto& [container, fraction] : lumens) {
    CAPTURE(container->describe());
    PackingProblem problem = grown(container, fraction);
    test::useCat(problem).planeSource = PlaneSource::catFaces;
    const PackingResult result = test::packAll(problem);
    const std::optional<TetrahedraSums>& sums = test::catStatistics(result).tetrahedra;
    REQUIRE(sums);
    CHECK(sums->runs > 0);
    CHECK(sums->attempts >= sums->runs);
    CHECK(sums->failures == 0);
  }
}

TEST_CASE("Method cat tests cells as they are written") {
  PackingProblem problem = grown(test::periodicCube(14.0), 0.35);
  // Coarse files: positions in steps of 0.01 µm.
  problem.physics.written = [](const Pose& pose) {
    Placement placement = pose.placement();
    for (int k = 0; k < 3; ++k)
      placement.translation[k] = 0.01 * std::round(100.0 * placement.translation[k]);
    return placement;
  };
  const PackingResult result = test::packAll(problem);
  for (std::size_t i = 0; i < result.cells.size(); ++i)
    CHECK(result.cells[i].placement.translation == problem.physics.written(result.poses[i]).translation);
}

TEST_CASE("Method cat grows single objects into thin copies of themselves") {
  for (const TriangleMesh& mesh :
       {test::cube(4.0), test::icosphere(2, 2.5), test::tetrahedron(), test::cone()}) {
    TriangleMesh around = mesh;
    for (Vec3& v : around.vertices) v *= std::cbrt(1.0 / 0.8);
    PackingProblem problem;
    problem.physics.add("object", std::make_shared<const Shape>(mesh), 1);
    problem.physics.container = makeVessel(around, {}, 0.2);
    test::useCat(problem);
    test::packAll(problem);
  }
}

TEST_CASE("Method cat gives the densest certified packing of full-size cells when not all of them fit") {
  PackingProblem problem = grown(test::periodicCube(12.0), 0.70);
  GrowthSettings& growth = test::useCat(problem).growth;
  growth.maxIterations = 15;
  growth.relaxationSweeps = 100;
  growth.attempts = 1;
  const PackingResult result = pack(problem);
  CHECK(result.outcome == Outcome::outOfReach);
  CHECK(std::int64_t(result.cells.size()) < problem.physics.species[0].count);
  CHECK(result.certificate.clean());
  CHECK(result.certificate.cells == std::int64_t(result.cells.size()));
  for (const Pose& pose : result.poses) CHECK(pose.scale == 1.0);
}

TEST_CASE("Method cat keeps limits and can be interrupted") {
  PackingProblem problem = grown(test::periodicCube(14.0), 0.35);
  problem.execution.limits.maxSweeps = 4;
  problem.execution.limits.fewerCells = false;
  const PackingResult limited = pack(problem);
  CHECK(limited.outcome == Outcome::outOfReach);
  CHECK(limited.statistics.engine->iterations() == 4);
  int seen = 0;
  problem.execution.limits = {};
  problem.execution.progress = [&](const Progress& progress) {
    ++seen;
    CHECK(progress.stage == "growth");
    CHECK(progress.unresolved >= 0);
  };
  problem.execution.interrupted = [&] { return seen >= 5; };
  const PackingResult stopped = pack(problem);
  CHECK(stopped.outcome == Outcome::interrupted);
  CHECK(stopped.cells.empty());
  CHECK(seen == 5);
}

TEST_CASE("Method cat does not succeed where cells overlap even at the initial scale") {
  PackingProblem problem = grown(test::periodicCube(12.0), 0.70);
  test::useCat(problem).growth.initialScale = 0.99;
  problem.execution.limits.fewerCells = false;
  const PackingResult result = pack(problem);
  CHECK(result.outcome == Outcome::outOfReach);
  CHECK(result.cellCount == 0);
}
