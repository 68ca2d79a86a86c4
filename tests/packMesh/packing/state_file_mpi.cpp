// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/error.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/pack.h"
#include "packMesh/packing/state_file.h"
#include "tests/support/catch.h"
#include "tests/support/deformed.h"
#include "tests/support/packings.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;
namespace fs = std::filesystem;

namespace {

PackingProblem sampleProblem() {
  return test::mixtureIn(makeBox({Vec3::Zero(), Vec3(55, 55, 26)}, {true, true, true}), 0.5, 5);
}

/// Packs and writes the states it is in after `every` more of them as <prefix>0.h5, <prefix>1.h5, ...
PackingResult packAndSave(PackingProblem problem, const std::string& prefix, int every) {
  int states = 0;
  problem.checkpoints = Checkpoints{
      [] { return true; },
      [&](const PackingState& state) {
        if (states++ % every == 0)
          writeState(prefix + std::to_string(states / every) + ".h5", problem, {"asked", {}, ""}, state);
      }};
  return pack(problem);
}

std::vector<double> numbersOf(const PackingResult& result, const Communicator& ranks) {
  std::vector<double> own;
  for (const Pose& pose : result.poses) {
    own.insert(own.end(), pose.position.data(), pose.position.data() + 3);
    own.insert(own.end(), pose.orientation.coeffs().data(), pose.orientation.coeffs().data() + 4);
  }
  return ranks.gatherAll(own);
}

}  // namespace

TEST_CASE("State files have the same bytes on any number of ranks, and any other number can continue them",
          "[mpi][long]") {
  const Communicator ranks = Communicator::world();
  std::optional<test::TemporaryFolder> folder;
  if (ranks.rank() == 0) folder.emplace();
  const fs::path path = ranks.broadcast(folder ? folder->path().string() : "", 0);
  constexpr int every = 3;

  PackingProblem shared = sampleProblem();
  shared.execution.communicator = ranks;
  const PackingResult result = packAndSave(shared, path / "shared", every);
  const std::vector<double> whole = numbersOf(result, ranks);
  std::int64_t files = 0;
  if (ranks.rank() == 0) {
    packAndSave(sampleProblem(), path / "alone", every);
    for (; fs::exists(path / ("alone" + std::to_string(files) + ".h5")); ++files)
      REQUIRE(test::readText(path / ("alone" + std::to_string(files) + ".h5")) ==
              test::readText(path / ("shared" + std::to_string(files) + ".h5")));
    REQUIRE(files >= 2);
    PackingProblem alone = sampleProblem();
    alone.resume = readState(path / "shared1.h5", alone);
    REQUIRE(numbersOf(pack(alone), Communicator()) == whole);
  }
  files = ranks.sum(files);
  for (std::int64_t n = 0; n < files; ++n) {
    shared.resume = readState(path / ("alone" + std::to_string(n) + ".h5"), shared);
    REQUIRE(numbersOf(pack(shared), ranks) == whole);
  }
}

TEST_CASE("Errors of reading or writing a state file are reported on all ranks", "[mpi]") {
  const Communicator ranks = Communicator::world();
  PackingProblem problem = sampleProblem();
  problem.execution.communicator = ranks;
  REQUIRE_THROWS_AS(readState("/no such folder/state.h5", problem), InputError);
  REQUIRE_THROWS_AS(packAndSave(problem, "/no such folder/state", 1), OutputError);
}

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

TEST_CASE("The final state of cells that ranks bring in any order has them by id, with their vertices",
          "[mpi]") {
  const Communicator ranks = Communicator::world();
  const std::int64_t size = ranks.size(), count = 5 * size + 1;
  std::vector<BodyState> own;
  std::vector<std::vector<Vec3>> vertices;
  const auto verticesOf = [](std::int64_t id) {
    return std::vector<Vec3>(id % 3, Vec3::Constant(double(id)));
  };
  for (std::int64_t id = count - 1; id >= 0; --id) {
    if (7 * id % size != ranks.rank()) continue;
    own.push_back(stateOf(id, 0, 0, {1.0, Quaternion::Identity(), Vec3::Constant(double(id))}));
    vertices.push_back(verticesOf(id));
  }
  const PackingState state = finalState(own, ranks, vertices);
  CHECK(state.position.stage == Stage::certificate);
  CHECK(state.cellCount == count);
  const auto [first, end] = IdShares(count, ranks).own();
  REQUIRE(std::int64_t(state.cells.size()) == end - first);
  REQUIRE(state.vertices.size() == state.cells.size());
  for (std::int64_t id = first; id < end; ++id) {
    CHECK(state.cells[id - first].id == id);
    CHECK(state.cells[id - first].position.x() == double(id));
    CHECK(state.vertices[id - first] == verticesOf(id));
  }
  CHECK(finalState(own, ranks).vertices.empty());
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
  if (ranks.rank() == 0) {
    pack(problemOn(Communicator(), place / "alone.h5"));
    CHECK(test::readText(place / "state.h5") == test::readText(place / "alone.h5"));
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
