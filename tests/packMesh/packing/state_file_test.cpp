// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/state_file.h"

#include <hdf5.h>
#include <sys/stat.h>

#include "packMesh/core/error.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/io/hdf5_file.h"
#include "packMesh/io/sealed_file.h"
#include "tests/support/catch.h"
#include "tests/support/deformed.h"
#include "tests/support/packings.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;
namespace fs = std::filesystem;

namespace {

PackingProblem sampleProblem() {
  return test::mixtureIn(test::periodicCube(25.0), 0.5, 3);
}

PackingState sampleState(PackingProblem problem) {
  PackingState state;
  problem.checkpoints = Checkpoints{[] { return true; }, [&](const PackingState& s) { state = s; }};
  pack(problem);
  state.failures[{1, 5}] = 3;
  state.demandedOfWall[7] = 0.25;
  state.relaxation.disturbed = {2, 9};
  return state;
}

void writeBytes(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

}  // namespace

TEST_CASE("A state reads back unchanged, and its bytes are reproducible") {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "state.h5", again = folder.path() / "again.h5";
  const PackingProblem problem = sampleProblem();
  const PackingState state = sampleState(problem);
  REQUIRE(state.cells.size() > 50);
  const StateRecord record = {
      "what was\nasked for", {{"a", 2, {1.0, 2.5, -3.0, 1e300}}, {"b\nc", 1, {}}}, ""};
  writeState(file, problem, record, state);

  const StateHead head = readStateHead(file);
  CHECK(head.record.request == record.request);
  CHECK(head.record.origin.empty());
  REQUIRE(head.record.inputs.size() == 2);
  for (int i = 0; i < 2; ++i) {
    CHECK(head.record.inputs[i].name == record.inputs[i].name);
    CHECK(head.record.inputs[i].columns == record.inputs[i].columns);
    CHECK(head.record.inputs[i].values == record.inputs[i].values);
  }
  REQUIRE(head.cells == state.cellCount);
  REQUIRE(head.files.empty());
  const FilesOfState together = {{"RBC.pos", "0a1b"}, {"a b.pos", "2c"}};
  const fs::path named = folder.path() / "named.h5";
  const auto prepared = preparedState(named, problem, {}, state, together);
  REQUIRE_FALSE(fs::exists(named));
  prepared->commit();
  REQUIRE(readStateHead(named).files == together);
  fs::remove(named);
  const PackingState found = readState(file, problem);
  REQUIRE(found.cellCount == state.cellCount);
  REQUIRE(found.cells.size() == state.cells.size());
  REQUIRE(found.failures == state.failures);
  REQUIRE(found.demandedOfWall == state.demandedOfWall);
  REQUIRE(found.relaxation.extraClearance == state.relaxation.extraClearance);
  REQUIRE(found.relaxation.disturbed == state.relaxation.disturbed);
  REQUIRE(found.relaxation.counts == state.relaxation.counts);
  REQUIRE(found.relaxation.blocks == state.relaxation.blocks);
  writeState(again, problem, head.record, found);
  REQUIRE(test::readText(again) == test::readText(file));
  REQUIRE(std::distance(fs::directory_iterator(folder.path()), {}) == 2);
}

TEST_CASE("Files that are not a state of this problem are rejected by name") {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "state.h5";
  PackingProblem problem = sampleProblem();
  writeState(file, problem, {}, sampleState(problem));
  const std::string bytes = test::readText(file);
  const auto refusal = [&] {
    const std::string message = test::messageOf<InputError>([&] { readState(file, problem); });
    if (!message.empty()) REQUIRE_THAT(message, Contains("state.h5"));
    return message;
  };
  REQUIRE(refusal().empty());

  SECTION("missing") {
    fs::remove(file);
    REQUIRE_THAT(refusal(), Contains("no such file"));
  }
  SECTION("empty, text, a folder, a pipe") {
    writeBytes(file, "");
    REQUIRE_THAT(refusal(), Contains("not a packMesh state"));
    writeBytes(file, "12\n1 2 3\n");
    REQUIRE_THAT(refusal(), Contains("not a packMesh state"));
    fs::remove(file);
    fs::create_directory(file);
    REQUIRE_THAT(refusal(), Contains("is a folder, expected a packMesh state"));
    fs::remove(file);
    REQUIRE(::mkfifo(file.c_str(), 0600) == 0);  // nobody writes into it: no waiting
    REQUIRE_THAT(refusal(), Contains("is a pipe, expected a packMesh state"));
  }
  SECTION("truncated") {
    for (const double share : {0.1, 0.5, 0.9, 0.9999}) {
      writeBytes(file, bytes.substr(0, std::size_t(share * double(bytes.size()))));
      REQUIRE_THAT(refusal(), Contains("truncated"));
    }
  }
  SECTION("another program's HDF5 file") {
    H5Fclose(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
    REQUIRE_THAT(refusal(), Contains("is an HDF5 file, but not a packMesh state"));
  }
  SECTION("another version") {
    std::string other = bytes;
    const std::string version = ", version 3\n";
    other.replace(other.find(version), version.size(), ", version 99");
    writeBytes(file, other);
    REQUIRE_THAT(refusal(), Contains("version 99") && Contains("this packMesh reads version 3"));
  }
  SECTION("a number changed") {
    const hid_t opened = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    const hid_t set = H5Dopen2(opened, "/cells/scale", H5P_DEFAULT);
    std::vector<double> scales(std::size_t(H5Dget_storage_size(set)) / sizeof(double), 1.0);
    scales[3] = 0.999;
    H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, scales.data());
    H5Dclose(set);
    H5Fclose(opened);
    REQUIRE_THAT(refusal(), Contains("damaged"));
  }
  SECTION("bits changed anywhere") {
    std::mt19937 random(1);
    for (int n = 0; n < 300; ++n) {
      std::string damaged = bytes;
      const std::size_t at = random() % (n % 3 == 0 ? sealSize : damaged.size());
      damaged[at] ^= char(1u << random() % 8);
      writeBytes(file, damaged);
      REQUIRE(!refusal().empty());
    }
  }
  SECTION("of another problem") {
    problem.physics.seed = 4;
    REQUIRE_THAT(refusal(), Contains("another problem"));
  }
}

TEST_CASE("A failure to write keeps the previous state") {
  const test::TemporaryFolder folder;
  const PackingProblem problem = sampleProblem();
  const PackingState state = sampleState(problem);
  REQUIRE_THROWS_WITH(writeState(folder.path() / "no such folder" / "state.h5", problem, {}, state),
                      Contains("state.h5") && Contains("cannot write to the folder"));
  const fs::path file = folder.path() / "state.h5";
  writeState(file, problem, {}, state);
  const std::string bytes = test::readText(file);
  fs::create_directory(temporaryName(file, 0, "new"));  // in the way: another name is taken
  writeState(file, problem, {}, state);
  REQUIRE(test::readText(file) == bytes);
  fs::create_directory(folder.path() / "folder.h5");
  REQUIRE_THROWS_WITH(writeState(folder.path() / "folder.h5", problem, {}, state),
                      Contains("folder.h5: is not a regular file and cannot be replaced"));
  REQUIRE_FALSE(fs::exists(temporaryName(folder.path() / "folder.h5", 0, "new")));
}

TEST_CASE("States with impossible numbers are rejected, even with a valid seal") {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "state.h5";
  const PackingProblem problem = sampleProblem();
  const PackingState state = sampleState(problem);
  const auto refused = [&](const auto& change) {
    PackingState changed = state;
    change(changed);
    writeState(file, problem, {}, changed);
    return test::messageOf<InputError>([&] { readState(file, problem); }).find("is damaged") !=
           std::string::npos;
  };
  REQUIRE_FALSE(refused([](PackingState&) {}));
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinite = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinite, -infinite, -1.0, 1e300}) {
    CAPTURE(bad);
    const bool negative = bad == -1.0;
    CHECK((negative || refused([&](PackingState& s) { s.cells[1].position[2] = bad; })));
    CHECK(refused([&](PackingState& s) { s.cells[1].orientation.x() = 2.0 * bad; }));
    CHECK(refused([&](PackingState& s) { s.cells[1].scale = bad; }));
    CHECK(refused([&](PackingState& s) { s.cells[1].extraWallClearance = bad; }));
    CHECK(refused([&](PackingState& s) { s.cells[1].overlap = bad; }));
    CHECK(refused([&](PackingState& s) { s.cells[1].moved = bad; }));
    CHECK(refused([&](PackingState& s) { s.relaxation.skin = bad; }));
    CHECK(refused([&](PackingState& s) { s.relaxation.slack = bad; }));
    CHECK(refused([&](PackingState& s) { s.relaxation.last.deepest = bad; }));
    CHECK(refused([&](PackingState& s) { s.demandedOfWall[0] = bad; }));
  }
  CHECK(refused([](PackingState& s) { s.cells[1].id = s.cells[0].id; }));
  CHECK(refused([](PackingState& s) { s.cells[1].scale = 0.0; }));
  CHECK(refused([](PackingState& s) { s.cells[1].orientation.coeffs().setZero(); }));
  CHECK(refused([](PackingState& s) { s.position.round = -1; }));
  CHECK(refused([](PackingState& s) { s.position.schedule.part = -1; }));
  CHECK(refused([](PackingState& s) { s.position.schedule.sweep = -1; }));
  CHECK(refused([](PackingState& s) { s.repairs = -1; }));
  CHECK(refused([](PackingState& s) { s.relaxation.sweeps = -1; }));
  CHECK(refused([](PackingState& s) { s.relaxation.blocks = {-1, 1, 1}; }));
}

namespace {

/// Changes a number of a table, and seals the state again, as whoever does so on purpose would.
void change(const fs::path& file, const std::string& table, std::size_t at, std::int32_t value) {
  {
    const Hdf5Handle open(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
    const Hdf5Handle set(H5Dopen2(open, table.c_str(), H5P_DEFAULT), H5Dclose),
        space(H5Dget_space(set), H5Sclose);
    std::vector<std::int32_t> all(std::size_t(H5Sget_simple_extent_npoints(space)));
    REQUIRE(H5Dread(set, H5T_NATIVE_INT32, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()) >= 0);
    all.at(at) = value;
    REQUIRE(H5Dwrite(set, H5T_NATIVE_INT32, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()) >= 0);
  }
  const std::string head = test::readText(file).substr(0, sealSize), by = "written by ";
  const std::size_t from = head.find(by) + by.size();
  REQUIRE(seal(file, {"state", stateVersion, head.substr(from, head.find('\n', from) - from)}).empty());
}

}  // namespace

TEST_CASE("Cells whose indices refer to nothing are refused, even with a valid seal") {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "state.h5", changed = folder.path() / "changed.h5";
  PackingProblem problem = test::redCellProblem(test::periodicCube(25.0), 0.1);
  Physics& physics = problem.physics;
  physics.shapes.push_back(
      std::make_shared<const Shape>(test::deformed(physics.shapes[0]->mesh(), 1), physics.shapes[0]));
  physics.species[0].deformed.push_back({1, {}});
  physics.species[0].count += 1;
  problem.checkpoints =
      Checkpoints{{}, [&](const PackingState& state) { writeState(file, problem, {}, state); }};
  REQUIRE(pack(problem).outcome == Outcome::certified);
  const StateCells whole = readStateCells(file, {});
  REQUIRE(whole.deformed);
  std::size_t deformed = 0;
  while (whole.cells[deformed].vertices.empty()) ++deformed;
  const auto refusal = [&](const std::string& table, std::size_t at, std::int32_t value) -> std::string {
    fs::copy_file(file, changed, fs::copy_options::overwrite_existing);
    change(changed, table, at, value);
    return test::messageOf<InputError>([&] { readStateCells(changed, {}); });
  };
  CHECK(refusal("/cells/membrane", deformed, 0).empty());
  constexpr std::int32_t most = std::numeric_limits<std::int32_t>::max();
  for (const std::int32_t row : {1, 5000, most})
    CHECK_THAT(refusal("/cells/membrane", deformed, row),
               Contains("changed.h5: table '/species/0/membranes' has 1 x "));
  for (const std::int32_t species : {1, most - 1, most})
    CHECK_THAT(refusal("/cells/species", 2, species), Contains("changed.h5: has no "));
  CHECK_THAT(refusal("/cells/species", 2, -1), Contains("is damaged"));
  for (const std::int32_t corner : {-1, 642, most})
    CHECK_THAT(refusal("/species/0/triangles", 7, corner),
               Contains("is damaged: a triangle refers to no vertex"));
}
