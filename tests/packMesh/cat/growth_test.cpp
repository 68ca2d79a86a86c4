// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/growth.h"

#include "packMesh/cat/chord_planes.h"
#include "packMesh/cat/step_halving.h"
#include "packMesh/certificate/certifier.h"
#include "packMesh/container/vessel.h"
#include "tests/support/catch.h"
#include "tests/support/growing.h"
#include "tests/support/packings.h"
#include "tests/support/physics.h"

using namespace packmesh;

namespace {

struct Run {
  Physics physics;
  Execution execution;
  std::vector<std::int64_t> counts;
  GrowthSettings settings;
  std::vector<Body> state;
  GrowthStatistics statistics;
  std::int64_t statesSeen = 0;

  Run(const std::vector<std::shared_ptr<const Shape>>& of, std::shared_ptr<const Container> in,
      std::vector<std::int64_t> howMany)
      : physics(test::physicsOf(of, std::move(in))), counts(std::move(howMany)) {}

  void seed() { state = test::seeded(physics, counts, settings.initialScale); }

  /// Grows; every accepted state is certified by itself, and no cell may be smaller than before.
  bool operator()() {
    if (state.empty()) seed();
    ChordPlanes chords(physics);
    std::vector<Body> last = state;
    GrowthCallbacks callbacks;
    callbacks.accepted = [&](const std::vector<Body>& now) {
      ++statesSeen;
      std::vector<PlacedCell> cells;
      REQUIRE(now.size() == last.size());
      for (std::size_t i = 0; i < now.size(); ++i) {
        REQUIRE(now[i].id == last[i].id);
        REQUIRE(now[i].scale >= last[i].scale);
        REQUIRE(now[i].scale <= 1.0);
        REQUIRE(physics.container->bounds().contains(now[i].position));
        cells.push_back({now[i].species, now[i].shape, now[i].pose().placement()});
      }
      REQUIRE(certify(certificateInputOf(physics, cells), 1e-3).clean());
      last = now;
    };
    return grow(physics, execution, settings, chords, callbacks, state, statistics);
  }
};

std::shared_ptr<const Container> sphereFor(const Shape& shape, int count, double fraction) {
  return makeSphere(Vec3::Zero(), std::cbrt(0.75 / M_PI * count * shape.volume() / fraction));
}

}  // namespace

TEST_CASE("Red cells grow in a periodic box through valid states") {
  Run run({test::redCellShape()}, test::periodicCube(16.0), {20});  // 0.40
  CHECK(run());
  CHECK(run.statistics.iterations > 5);
  CHECK(run.statesSeen == run.statistics.iterations + run.statistics.relaxationsKept);
  CHECK(run.statistics.planes > 0);
  CHECK(run.statistics.pivots > 0);
  for (const Body& cell : run.state) CHECK(cell.scale == 1.0);
}

TEST_CASE("Any closed mesh grows in a sphere") {
  for (const TriangleMesh& mesh :
       {sample::torus(Vec3::Zero(), 3.0, 1.0, 32, 16), test::bumpyMesh(5), test::hookMesh()}) {
    const auto shape = std::make_shared<const Shape>(mesh);
    Run run({shape}, sphereFor(*shape, 8, 0.20), {8});
    CHECK(run());
  }
}

TEST_CASE("A mixture grows in a cylinder") {
  Run run({test::redCellShape(), test::hemocellShape("PLT"), test::hemocellShape("WBC")},
          makeCylinder(Vec3(12.0, 0.0, 0.0), 0, 10.0, 24.0, true), {20, 10, 1});
  CHECK(run());
}

TEST_CASE("Growth keeps clearances and orientations") {
  Run run({test::redCellShape()}, makeBox(Box{Vec3::Zero(), Vec3::Constant(18.0)}, {true, true, false}),
          {16});
  run.physics.clearance = 0.1;
  run.physics.wallClearance = 0.3;
  run.physics.rotate = false;
  REQUIRE(run());
  for (const Body& cell : run.state) {
    CHECK(cell.orientation.coeffs() == Quaternion::Identity().coeffs());
    for (const Vec3& v : test::redCellShape()->mesh().vertices) {
      const double z = cell.pose().placement()(v).z();
      CHECK(std::min(z, 18.0 - z) >= 0.3);
    }
  }
}

TEST_CASE("Growth gives the same bytes for the same seed and another packing for another seed") {
  const auto poses = [](std::uint64_t seed) {
    Run run({test::redCellShape()}, test::periodicCube(14.0), {12});
    run.physics.seed = seed;
    REQUIRE(run());
    return run.state;
  };
  const std::vector<Body> first = poses(1), again = poses(1), other = poses(2);
  for (std::size_t i = 0; i < first.size(); ++i) {
    CHECK(first[i].position == again[i].position);
    CHECK(first[i].orientation.coeffs() == again[i].orientation.coeffs());
    CHECK(first[i].position != other[i].position);
  }
}

TEST_CASE("A relaxation finishes the last cells when the iterations of a barrier are used up") {
  Run run({test::redCellShape()}, test::periodicCube(16.0), {20});
  run.settings.maxIterations = 4;  // fewer than patience allows to judge
  run.settings.patience = 5;
  CHECK(run());
  CHECK(run.statistics.relaxationsKept > 0);
  run.state.clear();
  run.settings.relaxationSweeps = 0;
  CHECK_FALSE(run());
}

TEST_CASE("A relaxation resolves stalled growth, and can be disabled") {
  Run helped({test::redCellShape()}, test::periodicCube(16.0), {26});  // 0.52
  CHECK(helped());
  CHECK(helped.statistics.relaxationsKept > 0);
  Run alone({test::redCellShape()}, test::periodicCube(16.0), {26});
  alone.settings.relaxationSweeps = 0;
  alone.settings.maxIterations = 20;
  alone();
  CHECK(alone.statistics.relaxations == 0);
}

TEST_CASE("Growth of cells that cannot fit ends with every cell as large as possible") {
  Run run({test::redCellShape()}, test::periodicCube(12.0), {16});  // 0.75
  run.settings.maxIterations = 10;
  run.settings.relaxationSweeps = 50;
  CHECK(!run());
  double mean = 0.0;
  for (const Body& cell : run.state) mean += cell.scale / 16.0;
  CHECK(mean > 0.8);
  CHECK(mean < 1.0);
}

TEST_CASE("Growth stops when requested") {
  Run run({test::redCellShape()}, test::periodicCube(16.0), {20});
  run.seed();
  ChordPlanes chords(run.physics);
  GrowthCallbacks callbacks;
  callbacks.stop = [&] { return run.statistics.iterations >= 3; };
  CHECK(!grow(run.physics, run.execution, run.settings, chords, callbacks, run.state, run.statistics));
  CHECK(run.statistics.iterations == 3);
}

TEST_CASE("Growth rejects an invalid initial state and names the cells") {
  Run run({test::redCellShape()}, test::periodicCube(16.0), {3});
  run.seed();
  ChordPlanes chords(run.physics);
  std::vector<Body> overlapping = run.state;
  overlapping[2].setPose(overlapping[0].pose());
  CHECK_THROWS_WITH(grow(run.physics, run.execution, run.settings, chords, {}, overlapping, run.statistics),
                    Contains("cells 0 and 2 overlap"));
  Run walled({test::redCellShape()}, makeSphere(Vec3::Zero(), 10.0), {3});
  walled.seed();
  ChordPlanes walledChords(walled.physics);
  walled.state[1].position = Vec3(9.9, 0.0, 0.0);
  CHECK_THROWS_WITH(grow(walled.physics, walled.execution, walled.settings, walledChords, {}, walled.state,
                         walled.statistics),
                    Contains("cell 1 meets the wall"));
}

TEST_CASE("A relaxation at a scale gives a valid state of that scale or changes nothing") {
  Run run({test::redCellShape()}, test::periodicCube(16.0), {20});
  run.seed();
  GrowingCells cells(run.physics, run.execution, run.state, 1e9, 0);
  REQUIRE(relaxAtScale(run.physics, run.execution, 0.8, 400, {}, cells));
  run.state = cells.own();
  for (const Body& cell : run.state) CHECK(cell.scale == 0.8);
  CHECK(test::examine(run.physics, run.state).clean());
  const std::vector<Body> before = run.state;
  CHECK(!relaxAtScale(run.physics, run.execution, 1.0, 1, {}, cells));
  run.state = cells.own();
  for (std::size_t i = 0; i < before.size(); ++i) {
    CHECK(run.state[i].scale == 0.8);
    CHECK(run.state[i].position == before[i].position);
  }
}
