// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/primitives.h"
#include "packMesh/core/random.h"
#include "packMesh/packing/state_file.h"
#include "packMesh/soft/soft_packing.h"
#include "packMesh/soft/soft_shares.h"
#include "tests/packMesh/soft/soft_meshes.h"
#include "tests/support/catch.h"

namespace packmesh {
namespace {

void requireSame(const SoftPacking& a, const SoftPacking& b) {
  REQUIRE(a.outcome == b.outcome);
  REQUIRE(a.iterations == b.iterations);
  REQUIRE(a.most.force == b.most.force);
  REQUIRE(a.cells.size() == b.cells.size());
  for (std::size_t i = 0; i < a.cells.size(); ++i) {
    REQUIRE(a.cells[i].species == b.cells[i].species);
    REQUIRE(a.cells[i].pose.position == b.cells[i].pose.position);
    REQUIRE(a.cells[i].vertices == b.cells[i].vertices);
  }
}

TEST_CASE("ranks have equal shares of soft cells, between planes", "[mpi]") {
  const Communicator world = Communicator::world();
  const int ranks = world.size();
  std::vector<Vec3> centers;
  for (std::uint64_t i = 0; i < 600; ++i) {
    const auto u = uniform4(1, RandomStream::orientation, i, 0);
    centers.emplace_back(120.0 * u[0], 20.0 * u[1], 10.0 * u[2]);
  }
  const SoftShares shares(centers, std::vector<std::int64_t>(centers.size(), 642), world);
  std::vector<std::int64_t> of(std::size_t(ranks), 0);
  for (std::size_t i = 0; i < centers.size(); ++i) ++of[shares.ownerOf(i)];
  for (const std::int64_t count : of) CHECK(std::abs(double(count) - 600.0 / ranks) <= 1.0);
  // Planes cross the long axis, so that only the cells at its ends and at a plane are near others.
  for (std::size_t i = 0; i < centers.size(); ++i)
    for (std::size_t j = 0; j < centers.size(); ++j)
      if (shares.ownerOf(i) < shares.ownerOf(j)) CHECK_FALSE(centers[i].x() > centers[j].x());
}

TEST_CASE("soft cells are the same on any number of ranks, those that are left, too", "[mpi]") {
  PackingProblem problem;
  const TriangleMesh red = sample::redCell(3);
  TriangleMesh small = sample::redCell(2);
  small.vertices = scaledBy(0.5, small.vertices);
  problem.physics.container = makeBox(Box{Vec3::Zero(), Vec3(18.0, 7.5, 9.0)}, {true, true, false});
  problem.physics.add("RBC", std::make_shared<const Shape>(red), 14);
  problem.physics.add("other", std::make_shared<const Shape>(small), 2);
  SoftLimits limits;
  limits.fewerCells = true;
  limits.iterations = 60;
  std::vector<PackingState> saved;
  const auto packedOn = [&](const Communicator& ranks) {
    PackingProblem one = problem;
    one.execution.communicator = ranks;
    int asked = 0;
    saved.clear();
    one.checkpoints = Checkpoints{[&] { return ++asked == 25; },
                                  [&](const PackingState& state) { saved.push_back(state); }};
    return packSoft(one, {{}, {}}, limits);
  };
  const SoftPacking alone = packedOn({});
  CHECK(alone.outcome == Outcome::outOfReach);
  CHECK(!alone.cells.empty());
  const PackingState expected = saved.front();
  const Communicator ranks = Communicator::world();
  requireSame(packedOn(ranks), alone);
  REQUIRE(saved.size() == 2);
  CHECK(ranks.gatherAll(saved.front().soft->cells) == expected.soft->cells);
  CHECK(ranks.gatherAll(saved.front().soft->vertices) == expected.soft->vertices);
  problem.resume = saved.front();
  requireSame(packedOn(ranks), alone);
}

}  // namespace
}  // namespace packmesh
