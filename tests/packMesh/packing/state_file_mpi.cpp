// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/state_file.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <optional>

#include "packMesh/core/error.h"
#include "tests/support/packings.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;
namespace fs = std::filesystem;

namespace {

PackingProblem sampleProblem() {
  return test::mixtureIn(makeBox({Vec3::Zero(), Vec3(55, 55, 26)}, {true, true, true}), 0.5, 5);
}

std::string readBytes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
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
          "[mpi]") {
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
      REQUIRE(readBytes(path / ("alone" + std::to_string(files) + ".h5")) ==
              readBytes(path / ("shared" + std::to_string(files) + ".h5")));
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
