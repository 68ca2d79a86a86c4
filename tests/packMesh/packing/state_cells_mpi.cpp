// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/state_cells.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <optional>

#include "packMesh/core/error.h"
#include "packMesh/packing/pack.h"
#include "packMesh/packing/state_file.h"
#include "tests/support/deformed.h"
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
  problem.physics.species[1].kind = problem.physics.species[0].name;  // two parts of one kind
  problem.execution.communicator = ranks;
  problem.checkpoints = Checkpoints{{}, [&](const PackingState& state) {
                                      writeState(file, problem, {"asked", {}, ""}, state);
                                    }};
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::certified);

  const StateCells state = readStateCells(file, ranks);
  CHECK(state.certified);
  CHECK(state.record.request == "asked");
  CHECK(ranks.sum(std::int64_t(state.cells.size())) == problem.physics.cellCount());
  REQUIRE(!state.species.empty());
  CHECK(state.species[0].name == problem.physics.species[0].name);
  CHECK(state.species[0].count == problem.physics.species[0].count + problem.physics.species[1].count);
  CHECK(state.species[0].mesh.vertices == problem.physics.shapes[0]->mesh().vertices);
  CHECK(state.species[0].mesh.triangles == problem.physics.shapes[0]->mesh().triangles);
  std::vector<double> read, packed;
  for (const Cell& cell : state.cells)
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

TEST_CASE("Deformed cells are packed, saved and read alike on any ranks", "[mpi]") {
  const Communicator ranks = Communicator::world();
  std::optional<test::TemporaryFolder> folder;
  if (ranks.rank() == 0) folder.emplace();
  const fs::path place = ranks.broadcast(folder ? folder->path().string() : "", 0);
  const auto problemOn = [&](const Communicator& on, const fs::path& file) {
    PackingProblem problem =
        test::redCellProblem(makeBox({Vec3::Zero(), Vec3(40, 30, 26)}, {true, false, false}), 0.2, 5);
    Physics& physics = problem.physics;
    for (int n = 0; n < 12; ++n)
      physics.shapes.push_back(
          std::make_shared<const Shape>(test::deformed(physics.shapes[0]->mesh(), n), physics.shapes[0]));
    const auto start = [](int n) {
      return Pose{1.0, Quaternion::Identity(), Vec3(1.0 + 10.0 * (n % 4), n < 4 ? 6.0 : 15.0, 13.0)};
    };
    Species fixed{"RBC, fixed", 0, 4, nullptr}, &red = physics.species[0];
    fixed.kind = "RBC";
    fixed.freedom.fixed = true;
    for (int n = 0; n < 12; ++n) (n < 4 ? fixed : red).deformed.push_back({n + 1, start(n)});
    red.deformed.insert(red.deformed.begin() + 4, 2, {8, {}});  // of the same shape, placed at random
    red.count += std::int64_t(red.deformed.size());
    physics.species.push_back(std::move(fixed));
    problem.execution.communicator = on;
    problem.checkpoints = Checkpoints{{}, [=](const PackingState& state) {
                                        writeState(file, problem, {"asked", {}, ""}, state);
                                      }};
    return problem;
  };
  const PackingProblem problem = problemOn(ranks, place / "state.h5");
  const PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::certified);
  const auto bytesOf = [&](const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  if (ranks.rank() == 0) {
    pack(problemOn(Communicator(), place / "alone.h5"));
    CHECK(bytesOf(place / "state.h5") == bytesOf(place / "alone.h5"));
  }
  (void)ranks.sum(std::int64_t(0));

  const StateCells state = readStateCells(place / "state.h5", ranks);
  REQUIRE(state.species.size() == 1);
  CHECK(state.species[0].count == problem.physics.cellCount());
  CHECK(state.period == Vec3(40, 0, 0));
  const std::int64_t first = ranks.sumBefore({std::int64_t(state.cells.size())}).front();
  const Species &red = problem.physics.species[0], &fixed = problem.physics.species[1];
  std::int64_t deformed = 0;
  for (std::size_t i = 0; i < state.cells.size(); ++i) {
    const std::int64_t number = first + std::int64_t(i);
    const bool isFixed = number >= red.count,
               isDeformed = isFixed || number < std::int64_t(red.deformed.size());
    deformed += isDeformed;
    REQUIRE(state.cells[i].vertices.empty() != isDeformed);
    if (!isDeformed) {
      CHECK(state.cells[i].shape == red.shape);
      continue;
    }
    const DeformedCell& cell = isFixed ? fixed.deformed[number - red.count] : red.deformed[number];
    CHECK(state.cells[i].shape == cell.shape);
    CHECK(state.cells[i].vertices == problem.physics.shapeOf(cell).mesh().vertices);
    if (isFixed) CHECK(state.cells[i].pose.position == cell.start->position);
  }
  CHECK(ranks.sum(deformed) == 14);
  // A run that continues from the end has the same cells.
  PackingProblem again = problem;
  again.checkpoints.reset();
  again.resume = readState(place / "state.h5", problem);
  CHECK(test::sameBits(pack(again), result));
}
