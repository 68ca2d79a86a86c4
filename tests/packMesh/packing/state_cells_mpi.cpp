// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/state_cells.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <optional>

#include "packMesh/core/error.h"
#include "packMesh/packing/pack.h"
#include "packMesh/packing/state_file.h"
#include "tests/support/packings.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;
namespace fs = std::filesystem;

TEST_CASE("The cells of a state are read in parts, whatever problem is at hand", "[mpi]") {
  const Communicator ranks = Communicator::world();
  std::optional<test::TemporaryFolder> folder;
  if (ranks.rank() == 0) folder.emplace();
  const fs::path file = fs::path(ranks.broadcast(folder ? folder->path().string() : "", 0)) / "state.h5";
  PackingProblem problem =
      test::mixtureIn(makeBox({Vec3::Zero(), Vec3(55, 55, 26)}, {true, true, true}), 0.3, 5);
  problem.physics.species[1].name =
      problem.physics.species[0].name + ", region 1";  // two parts of one species
  problem.execution.communicator = ranks;
  problem.checkpoints =
      Checkpoints{{}, [&](const PackingState& state) { writeState(file, problem, {"packMesh"}, state); }};
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::certified);

  const StateCells state = readStateCells(file, ranks);
  CHECK(state.certified);
  CHECK(state.command == std::vector<std::string>{"packMesh"});
  CHECK(ranks.sum(std::int64_t(state.cells.size())) == problem.physics.cellCount());
  REQUIRE(!state.species.empty());
  CHECK(state.species[0].name == problem.physics.species[0].name);
  CHECK(state.species[0].count == problem.physics.species[0].count + problem.physics.species[1].count);
  CHECK(state.species[0].mesh.vertices == problem.physics.species[0].shape->mesh().vertices);
  CHECK(state.species[0].mesh.triangles == problem.physics.species[0].shape->mesh().triangles);
  std::vector<double> read, packed;
  for (const StateCell& cell : state.cells)
    read.insert(read.end(), cell.pose.position.data(), cell.pose.position.data() + 3);
  for (const Pose& pose : result.poses)
    packed.insert(packed.end(), pose.position.data(), pose.position.data() + 3);
  CHECK(ranks.gatherAll(read) == ranks.gatherAll(packed));

  if (ranks.rank() == 0) std::ofstream(file, std::ios::app) << "more";
  (void)ranks.sum(std::int64_t(0));
  CHECK_THROWS_AS(readStateCells(file, ranks), InputError);
  CHECK_THROWS_AS(readStateCells(file.string() + " no such file", ranks), InputError);
  (void)ranks.sum(std::int64_t(0));
}
