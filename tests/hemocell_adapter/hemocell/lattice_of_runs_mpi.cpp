// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/lattice_of_runs.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "hemocell_adapter/hemocell/voxel_distance.h"
#include "packMesh/core/error.h"

using namespace packmesh;
using namespace packmesh::hemocell;

namespace {

/// Balls of fluid; every rank has the runs of some rows.
std::vector<FluidRun> runsOf(const std::array<int, 3>& nodes, const Communicator& ranks, int seed) {
  std::mt19937 random(seed);
  std::vector<std::array<double, 4>> balls;
  for (int n = 0; n < 6; ++n) {
    std::array<double, 4> ball;
    for (int a = 0; a < 3; ++a) ball[a] = std::uniform_real_distribution<>(0, nodes[a])(random);
    ball[3] = std::uniform_real_distribution<>(3, 30)(random);
    balls.push_back(ball);
  }
  std::vector<FluidRun> runs;
  for (int k = 0; k < nodes[2]; ++k)
    for (int j = 0; j < nodes[1]; ++j) {
      if ((j + 3 * k) % ranks.size() != ranks.rank()) continue;
      for (int i = 0; i < nodes[0]; ++i) {
        bool fluid = false;
        for (const auto& b : balls) fluid = fluid || std::hypot(i - b[0], j - b[1], k - b[2]) < b[3];
        if (fluid) runs.push_back({i, i, j, k});
      }
    }
  return runs;
}

int differences(const Lattice& a, const Lattice& b) {
  REQUIRE(a.nodes() == b.nodes());
  int count = 0;
  for (int k = 0; k < a.nodes()[2]; ++k)
    for (int j = 0; j < a.nodes()[1]; ++j)
      for (int w = 0; w < a.wordsPerRow(); ++w) count += a.word(w, j, k) != b.word(w, j, k);
  return count;
}

}  // namespace

TEST_CASE("A lattice that ranks share has the nodes of one that each of them has", "[mpi]") {
  const Communicator ranks = Communicator::world();
  const int ranksPerNode = GENERATE(1, 2, 1000);
  for (const std::array<int, 3> nodes : {std::array<int, 3>{130, 50, 41}, {64, 8, 8}, {7, 30, 61}}) {
    CAPTURE(nodes[0]);
    const std::vector<FluidRun> runs = runsOf(nodes, ranks, nodes[0]);
    const auto whole = latticeOfRuns(nodes, 0.5, runs, ranks, 1 << 30);
    const auto shared = latticeOfRuns(nodes, 0.5, runs, ranks, 0, ranksPerNode);
    REQUIRE(!whole->isView());
    REQUIRE(shared->isView());
    CHECK(shared->fluidNodes() == whole->fluidNodes());
    CHECK(shared->fluidRange() == whole->fluidRange());
    CHECK(differences(*shared, *whole) == 0);
    for (const int radius : {1, 2, 9}) CHECK(differences(shared->eroded(radius), whole->eroded(radius)) == 0);
    for (const std::array<int, 3> margin : {std::array<int, 3>{5, 0, 0}, {0, 8, 3}, {33, 33, 33}}) {
      CHECK(differences(shared->repeated(margin), whole->repeated(margin)) == 0);
      CHECK(differences(shared->repeated(margin).eroded(2), whole->repeated(margin).eroded(2)) == 0);
    }
  }
}

TEST_CASE("Distances in a lattice that ranks share have the right sign and are lower bounds", "[mpi]") {
  const Communicator ranks = Communicator::world();
  const std::array<int, 3> nodes = {100, 60, 50};
  const std::vector<FluidRun> runs = runsOf(nodes, ranks, 5);
  const auto whole = latticeOfRuns(nodes, 0.5, runs, ranks, 1 << 30),
             shared = latticeOfRuns(nodes, 0.5, runs, ranks, 0);
  const VoxelDistance near(*whole), distributed(*shared);
  std::mt19937 random(3);
  int wrongSide = 0, differsNear = 0, tooFar = 0;
  for (int n = 0; n < 20000; ++n) {
    Vec3 p;
    for (int a = 0; a < 3; ++a) p[a] = std::uniform_real_distribution<>(-0.2, 0.5 * nodes[a] - 0.3)(random);
    const double a = near.at(p).distance, b = distributed.at(p).distance;
    wrongSide += (a > 0.0) != (b > 0.0);
    differsNear += std::abs(a) < 0.99 * VoxelDistance::fineReach * 0.5 && a != b;
    // The other one is lower by up to its own error, too.
    tooFar += b > a + 0.5 * 0.5 && a > 0.0;
  }
  CHECK(wrongSide == 0);
  CHECK(differsNear == 0);
  CHECK(tooFar == 0);
}

TEST_CASE("A lattice that ranks share without fluid is refused on all ranks", "[mpi]") {
  CHECK_THROWS_AS(latticeOfRuns({9, 9, 9}, 0.5, {}, Communicator::world(), 0), InputError);
}
