// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/primitives.h"
#include "packMesh/core/random.h"
#include "packMesh/packing/pack.h"
#include "packMesh/soft/soft_engine.h"
#include "packMesh/soft/soft_shares.h"
#include "tests/packMesh/soft/soft_meshes.h"
#include "tests/support/catch.h"

namespace packmesh {
namespace {

void requireSame(const PackingResult& a, const PackingResult& b, const Communicator& ranks) {
  REQUIRE(a.outcome == b.outcome);
  REQUIRE(sample::reachedBy(a).done == sample::reachedBy(b).done);
  REQUIRE(sample::reachedBy(a).most.force == sample::reachedBy(b).most.force);
  REQUIRE(ranks.gatherAll(a.cells).size() == b.cells.size());
  const std::size_t first = std::size_t(ranks.sumBefore({std::int64_t(a.cells.size())}).front());
  for (std::size_t i = 0; i < a.cells.size(); ++i) {
    REQUIRE(a.cells[i].species == b.cells[first + i].species);
    REQUIRE(a.poses[i].position == b.poses[first + i].position);
    REQUIRE(a.deformed->physics->shapeOf(a.cells[i]).mesh().vertices ==
            b.deformed->physics->shapeOf(b.cells[first + i]).mesh().vertices);
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

/// @param cells the most of which the first rank alone computes, or more
PackingProblem twoSpecies(int cells) {
  PackingProblem problem;
  TriangleMesh small = sample::redCell(2);
  small.vertices = scaledBy(0.5, small.vertices);
  problem.physics.container =
      makeBox(Box{Vec3::Zero(), Vec3(1.3 * cells - 2.0, 7.5, 9.0)}, {true, true, false});
  problem.physics.add("RBC", std::make_shared<const Shape>(sample::redCell(3)), cells - 2);
  problem.physics.add("other", std::make_shared<const Shape>(small), 2);
  problem.execution.limits.maxSweeps = 60;
  problem.engine = sample::softEngine(problem);
  return problem;
}

TEST_CASE("soft cells are the same on any number of ranks, those that are left, too", "[mpi]") {
  const int cells = GENERATE(int(SoftShares::few), int(SoftShares::few) + 2);
  PackingProblem problem = twoSpecies(cells);
  std::vector<PackingState> saved;
  const auto packedOn = [&](const Communicator& ranks) {
    PackingProblem one = problem;
    one.execution.communicator = ranks;
    saved.clear();
    one.checkpoints = Checkpoints{[] { return true; },
                                  [&](const PackingState& state) {
                                    if (state.position.stage == Stage::engine) saved.push_back(state);
                                  }};
    return pack(one);
  };
  const auto at40 = [&] {
    const auto found = std::find_if(saved.begin(), saved.end(),
                                    [](const PackingState& one) { return one.engine->iterations() == 40; });
    REQUIRE(found != saved.end());
    return *found;
  };
  const auto cellsOf = [](const PackingState& state) -> const SoftCellsState& {
    return dynamic_cast<const SoftState&>(*state.engine).cells;
  };
  const PackingResult alone = packedOn({});
  CHECK(alone.outcome == Outcome::outOfReach);
  CHECK(!alone.cells.empty());
  const PackingState expected = at40();
  const Communicator ranks = Communicator::world();
  requireSame(packedOn(ranks), alone, ranks);
  CHECK(ranks.gatherAll(cellsOf(at40()).cells) == cellsOf(expected).cells);
  CHECK(ranks.gatherAll(cellsOf(at40()).vertices) == cellsOf(expected).vertices);
  problem.resume = at40();
  requireSame(packedOn(ranks), alone, ranks);
}

TEST_CASE("few soft cells are computed by the first rank, to which the others leave the processor", "[mpi]") {
  PackingProblem problem = twoSpecies(8);
  problem.execution.communicator = Communicator::world();
  const Communicator& ranks = problem.execution.communicator;
  problem.execution.limits.fewerCells = false;
  SoftLimits limits;
  limits.force = limits.aim = 1e-6;  // never reached: all attempts do as many iterations as they may
  problem.engine = sample::softEngine(problem, limits);
  const auto sent = [&](std::int64_t iterations) {
    problem.execution.limits.maxSweeps = iterations;
    const std::int64_t before = ranks.traffic().messages;
    CHECK(sample::reachedBy(pack(problem)).done == iterations);
    return double(ranks.traffic().messages - before);
  };
  const double few = sent(100), more = sent(300);
  CHECK(more - few < 0.1 * 3 * 200 * ranks.size());  // of the first rank to all others, for several steps
  const SoftShares shares(std::vector<Vec3>(8, Vec3::Zero()), std::vector<std::int64_t>(8, 1), ranks);
  CHECK(shares.mine().size() == (ranks.rank() == 0 ? 8 : 0));
}

}  // namespace
}  // namespace packmesh
