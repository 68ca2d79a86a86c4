// SPDX-License-Identifier: AGPL-3.0-or-later
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <map>
#include <random>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/settings/command_line.h"
#include "hemocell_adapter/settings/request_json.h"
#include "packMesh/core/error.h"
#include "packMesh/packing/state_file.h"
#include "tests/hemocell_adapter/executable.h"
#include "tests/hemocell_adapter/refusal.h"
#include "tests/support/catch.h"
#include "tests/support/places.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
namespace fs = std::filesystem;

TEST_CASE("Files in the folder of a state are found where the state is") {
  const Request request =
      parseCommandLine("packMesh", {"/a & b/run/config.xml", "--start=/a & b/run/in/RBC.pos", "--fixed",
                                    "/a & b/runs/PLT.pos", "--report", "/x/a & b/run/y.json", "--restart",
                                    "/a & b/run/state.h5", "--blood", "/a & b/run/caf\xe9.h5"})
          .request;
  const StateRecord record = recordOf(request, "/a & b/other/../run/state.h5");
  CHECK_THAT(record.request, Contains(R"("config":{"beside":"config.xml"})") &&
                                 Contains(R"("/a & b/runs/PLT.pos")") && !Contains("restart"));
  Request same = requestIn(record, "/a & b/run/state.h5");
  CHECK(same.config == "/a & b/run/config.xml");
  CHECK(findSpecies(same, "RBC")->start->string() == "/a & b/run/in/RBC.pos");
  CHECK(same.blood->string() == "/a & b/run/caf\xe9.h5");
  CHECK(same.output.reportFile == "/x/a & b/run/y.json");
  CHECK(same.originOf("report")->kind == Origin::Kind::state);
  const Request moved = requestIn(record, "/new/s.h5");
  CHECK(moved.config == "/new/config.xml");
  CHECK(findSpecies(moved, "PLT")->fixed->string() == "/a & b/runs/PLT.pos");
}

TEST_CASE("Files that were named from the working directory are found where the state is") {
  const Request request = parseCommandLine("packMesh", {"case/config.xml", "--vessel", "v.stl", "1e6",
                                                        "--start", "case/RBC.pos", "--profile", "developed"})
                              .request;
  const StateRecord record = recordOf(request, "case/s.h5");
  CHECK_THAT(record.request, Contains(R"({"beside":"config.xml"})") && Contains(R"({"beside":"../v.stl"})") &&
                                 Contains(R"("profile":"developed")"));
  const Request moved = requestIn(record, "/new/case/s.h5");
  CHECK(moved.config == "/new/case/config.xml");
  CHECK(moved.container->lumen->file.string() == "/new/v.stl");
  CHECK(findSpecies(moved, "RBC")->start->string() == "/new/case/RBC.pos");
  CHECK_THAT(recordOf(request, "s.h5").request, Contains(R"({"beside":"v.stl"})"));
  const StateRecord earlier{R"({"container":{"lumen":{"kind":"mesh","file":"v.stl"}}})", {}, ""};  // 1.2
  CHECK(requestIn(earlier, "/new/case/s.h5").container->lumen->file.string() == "v.stl");
}

TEST_CASE("Numbers that were given are in the record of a state") {
  const auto given = std::make_shared<MemoryInput>(
      MemoryInput{"vessel", heading("vessel"), {{"vertices", 3, {0, 0, 1, 2, 3, 4}}}});
  Request request;
  request.container.emplace().lumen.emplace().kind = SolidRequest::Kind::mesh;
  request.container->lumen->file = Source(std::shared_ptr<const MemoryInput>(given));
  const StateRecord record = recordOf(request, "s.h5");
  const Request again = requestIn(record, "s.h5");
  REQUIRE(again.container->lumen->file.given);
  CHECK(again.container->lumen->file.given->find("vertices")->values == given->tables[0].values);
  CHECK(recordOf(overridden(again, request), "s.h5").inputs.size() == 1);
}

TEST_CASE("A state without a request is not continued") {
  CHECK_THROWS_WITH(requestIn({"", {}, "iteration 3"}, "s.h5"), Contains("has the cells of a simulation"));
  CHECK_THROWS_WITH(requestIn({}, "s.h5"), Contains("earlier version"));
  CHECK_THROWS_WITH(requestIn({"{", {}, ""}, "s.h5"), Contains("not JSON"));
  CHECK_THROWS_WITH(requestIn({"{\"sed\": 1}", {}, ""}, "s.h5"), Contains("s.h5: sed: is no setting"));
}

TEST_CASE("The cells of a state of version 2 are read, and its run is not continued", "[executable]") {
  const TemporaryFolder folder;
  const fs::path state = folder / "two.h5";
  fs::copy(fs::path(test::sourceFolder) / "tests/data/state_version_2.h5", state);
  const StateCells cells = readStateCells(state, Communicator());
  CHECK(cells.cells.size() == 2);
  CHECK(cells.species.at(0).name == "PLT");
  CHECK(cells.certified);
  CHECK_THROWS_WITH(readStateHead(state), Contains("version 2") && Contains("reads version 3"));
  ok(folder, "10 10 10 --plt 3 --ends periodic --start two.h5");
}

TEST_CASE("Runs of version 1.2 that ended at a limit are continued on any number of ranks",
          "[executable][mpi]") {
  const auto [file, asked] = GENERATE(
      std::pair<std::string, std::string>{"state_1.2_soft.h5",
                                          "2.8 2.8 2.8 --ends periodic --plt 4 --soft --clearance 0"},
      std::pair<std::string, std::string>{"state_1.2_growth.h5",
                                          "4 4 4 --ends periodic --plt 4 --method cat --clearance 0"});
  if (asked.find("cat") != asked.npos && !hasCat()) return;
  const TemporaryFolder folder;
  fs::copy(fs::path(test::sourceFolder) / "tests/data" / file, folder / "s.checkpoint.h5");
  ok(folder, asked + " --state whole.h5");
  const auto cellsIn = [&](const char* name) { return readStateCells(folder / name, Communicator()).cells; };
  const std::vector<Cell> whole = cellsIn("whole.h5");
  REQUIRE(whole.size() == 4);
  for (const int ranks : {1, 2}) {
    const std::string restart = "--restart s.checkpoint.h5 --max-iterations 5000 --state rest.h5";
    const Ran ran = withExit(0, runProcess(folder, restart, "OMP_NUM_THREADS=1 " + onRanks(ranks)));
    CHECK_THAT(ran.out, Contains("Continuing from s.checkpoint.h5: after "));
    const std::vector<Cell> rest = cellsIn("rest.h5");
    REQUIRE(rest.size() == whole.size());
    for (std::size_t i = 0; i < whole.size(); ++i) {
      CHECK(rest[i].pose.position == whole[i].pose.position);
      CHECK(rest[i].vertices == whole[i].vertices);
    }
  }
}

TEST_CASE("A state is continued after its folder was moved, and names no place of the program",
          "[executable]") {
  const TemporaryFolder folder;
  const fs::path case_ = folder / "case";
  fs::create_directory(case_);
  {
    const SampleCase sample;
    fs::copy(sample.path(), case_, fs::copy_options::recursive);
  }
  ok(folder, "'" + (case_ / "config.xml").string() + "' --hematocrit 0.1 --state '" +
                 (case_ / "s.h5").string() + "'");
  const std::string before = readText(case_ / "RBC.pos");
  const std::string state = readText(case_ / "s.h5");
  CHECK_THAT(state, Contains("{\"beside\":\"config.xml\"}"));
  CHECK(state.find(test::programFolder) == std::string::npos);
  CHECK(state.find(case_.string()) == std::string::npos);
  fs::remove(case_ / "RBC.pos");
  fs::rename(case_, folder / "moved");
  ok(folder, "--restart moved/s.h5");
  CHECK(readText(folder / "moved/RBC.pos") == before);
}

// Runs that are ended by signals, and go on.

using namespace packmesh::test;
using packmesh::readStateHead;
using packmesh::hemocell::ExitCode;
using packmesh::hemocell::hasCat;

namespace {

const std::string problem = "56 28 28 --ends periodic --hematocrit 0.55 --seed 3 --plt_ratio 0.05";

std::string positions(const fs::path& folder) {
  return readText(folder / "RBC.pos") + readText(folder / "PLT.pos");
}

/// A problem, what an undisturbed run of it writes, and how long it takes [s].
struct Undisturbed {
  std::string problem, positions;
  double seconds = 0.0;
};

const std::string oftenSaved = " --checkpoint-every 0.001";
const char* const checkpoint = "state.checkpoint.h5";

Undisturbed undisturbed(const std::string& arguments, const std::string& launcher = "") {
  const TemporaryFolder folder;
  const auto start = std::chrono::steady_clock::now();
  withExit(0, runProcess(folder, arguments + oftenSaved, launcher));
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  return {arguments, positions(folder.path()), took.count()};
}

/// How long a run is let be, at random: where a machine gets slower or faster meanwhile, this follows.
class Moments {
 public:
  explicit Moments(double seconds) : seconds_(seconds) {}
  std::string next() { return std::to_string(share_(random_) * seconds_); }
  void wasTooLate() { seconds_ *= 0.9; }
  void wasTooEarly() { seconds_ *= 1.1; }

 private:
  double seconds_;  ///< of an undisturbed run
  std::mt19937 random_{1};
  std::uniform_real_distribution<double> share_{0.02, 1.0};
};

/// Stops runs at random moments by one of the signals, in turn, and lets them go on.
/// At least a quarter as often as `wanted` there is a state to go on from.
void requireSameAfterKills(const Undisturbed& expected, int wanted, const std::vector<std::string>& signals,
                           const std::string& launcher = "") {
  Moments moments(expected.seconds);
  int kills = 0, saved = 0;
  while (kills < wanted || saved < wanted / 4) {
    REQUIRE(kills < 20 * wanted);
    const TemporaryFolder folder;
    for (int again = 0; again < 6; ++again) {
      const bool begun = fs::exists(folder / checkpoint);
      saved += begun;
      if (begun) REQUIRE_NOTHROW(readStateHead(folder / checkpoint));  // without cells: not begun to grow
      const std::string arguments =
          begun ? std::string("--restart ") + checkpoint : expected.problem + oftenSaved;
      const std::string limit = moments.next();
      const bool last = again == 5;
      const std::string killer =
          "timeout --foreground -s " + signals[again % signals.size()] + " " + limit + " ";
      const Ran ran = runProcess(folder, arguments, (last ? "" : killer + "env ") + launcher);
      CAPTURE(kills, again, limit, ran.exitCode, ran.all());
      if (last) REQUIRE(ran.exitCode == 0);
      if (ran.exitCode == 0 && !last) moments.wasTooLate();
      if (ran.exitCode == 0) break;
      ++kills;
      if (!fs::exists(folder / checkpoint)) moments.wasTooEarly();
      // What is there is whole: the signal may have come when all was done.
      for (const char* name : {"RBC.pos", "PLT.pos"})
        if (fs::exists(folder / name))
          REQUIRE(expected.positions.find(readText(folder / name)) != std::string::npos);
    }
    REQUIRE(positions(folder.path()) == expected.positions);
  }
}

}  // namespace

TEST_CASE("A run killed at random times continues to the same files", "[long]") {
  requireSameAfterKills(undisturbed("20 20 20 --ends periodic --hematocrit 0.57 --plt_ratio 0.05"), 24,
                        {"TERM", "KILL"});
}

TEST_CASE("Growth killed at random times continues to the same files", "[long]") {
  if (!hasCat()) return;
  const Undisturbed grown = undisturbed("18 18 18 --hematocrit 0.35 --plt_ratio 0 --method cat");
  requireSameAfterKills(grown, 8, {"TERM", "KILL"});
}

TEST_CASE("Two ranks stopped at random times continue to the same files", "[ranks][long]") {
  const Undisturbed packed = undisturbed("56 28 28 --hematocrit 0.5 --plt_ratio 0.05", onRanks(2));
  requireSameAfterKills(packed, 4, {"TERM"}, onRanks(2, 1));  // mpirun sends TERM to the ranks, too
}

TEST_CASE("A run continues on a different number of ranks after a signal to all", "[ranks][long]") {
  const std::string expected = undisturbed(problem).positions;
  for (const int ranks : {1, 3}) {
    CAPTURE(ranks);
    const TemporaryFolder folder;
    // SIGTERM as soon as there is a state, or to a run that has ended.
    writeText(folder / "script", onRanks(ranks, 1) + " '" + programFolder + "/packMesh' " + problem +
                                     R"( --checkpoint-every 0.01 > out 2>&1 &
pid=$!
while kill -0 $pid 2> /dev/null && [ ! -f state.checkpoint.h5 ]; do sleep 0.02; done
kill -TERM $pid 2> /dev/null
wait $pid
)");
    REQUIRE(std::system(
                ("cd '" + folder.path().string() + "' && " + awaitingAll() + " bash script").c_str()) != -1);
    INFO(readText(folder / "out"));
    const bool ended = fs::exists(folder / "state.h5");
    REQUIRE((ended || fs::exists(folder / checkpoint)));
    REQUIRE(
        runProcess(folder, std::string("--restart ") + (ended ? "state.h5" : checkpoint), onRanks(4 - ranks))
            .exitCode == 0);
    REQUIRE(positions(folder.path()) == expected);
  }
}

// But for repair, which lasts a millisecond: packing_problem_test.cpp interrupts it.
TEST_CASE("SIGTERM in any stage keeps the previous files and saves a state of that stage", "[long]") {
  struct Case {
    std::string arguments;
    std::vector<std::string> stages;  ///< which it passes through
  };
  const std::string before = "1\n4 4 4 0 0 0\n";
  for (const Case& wanted : {
           Case{"70 70 70 --hematocrit 0.3 --plt_ratio 0", {"relaxation", "certificate"}},
           Case{"25 25 25 --hematocrit 0.63 --plt_ratio 0 --max-time 1 --best-effort", {"relaxation"}},
           Case{"18 18 18 --hematocrit 0.35 --plt_ratio 0 --method cat", {"growth"}},
       }) {
    if (wanted.stages.front() == "growth" && !hasCat()) continue;
    Moments moments(undisturbed(wanted.arguments).seconds);
    std::map<std::string, int> seen;  // runs stopped in each stage
    const auto allSeen = [&] {
      return std::all_of(wanted.stages.begin(), wanted.stages.end(),
                         [&](auto& stage) { return seen[stage] > 0; });
    };
    for (int runs = 0; !allSeen(); ++runs) {
      CAPTURE(wanted.arguments, runs);
      REQUIRE(runs < 2000);
      const TemporaryFolder folder;
      writeText(folder / "RBC.pos", before);
      const Ran ran = runProcess(folder, wanted.arguments + " --state s.h5",
                                 "timeout --foreground --preserve-status -s TERM " + moments.next());
      CAPTURE(ran.exitCode, ran.all());
      if (ran.exitCode == 0) {
        moments.wasTooLate();
        continue;
      }
      REQUIRE((ran.exitCode == int(ExitCode::interrupted) ||
               (ran.exitCode == 128 + SIGTERM && ran.all().empty())));  // before it knew of signals
      REQUIRE(readText(folder / "RBC.pos") == before);
      const fs::path saved = folder / "s.checkpoint.h5";
      const bool state = fs::exists(saved);
      if (!state) moments.wasTooEarly();
      if (state) ++seen[readStateHead(saved).stage];
      REQUIRE(std::distance(fs::directory_iterator(folder.path()), {}) == 1 + state);
    }
  }
}

TEST_CASE("SIGUSR1 saves the state and continues, SIGTERM saves it and prints how to continue") {
  const TemporaryFolder folder;
  const std::string program = (fs::path(programFolder) / "packMesh").string();
  // 0.62 takes minutes: it is still at it when the signals come.
  writeText(folder / "script", "'" + program + R"(' 40 40 40 --hematocrit 0.62 --state s.h5 > out 2>&1 &
pid=$!
while kill -0 $pid; do
  sleep 0.1
  [ -s out ] && kill -USR1 $pid
  [ -f s.checkpoint.h5 ] && break
done
kill -0 $pid && touch alive
kill -TERM $pid
wait $pid
)");
  const int status = std::system(("cd '" + folder.path().string() + "' && bash script").c_str());
  REQUIRE(WIFEXITED(status));
  REQUIRE(fs::exists(folder / "alive"));
  REQUIRE_FALSE(fs::exists(folder / "s.h5"));
  REQUIRE(WEXITSTATUS(status) == int(ExitCode::interrupted));
  const std::string out = readText(folder / "out");
  REQUIRE_THAT(out, Contains("packMesh --restart s.checkpoint.h5"));
  REQUIRE(readStateHead(folder / "s.checkpoint.h5").cells > 400);
  CHECK_THAT(ended(folder, int(ExitCode::badInput), "--restart s.h5").err,
             Contains("s.h5: no such file; the run has not ended, and is continued from s.checkpoint.h5"));
  REQUIRE_FALSE(fs::exists(folder / "RBC.pos"));
}

TEST_CASE("The state of a finished run gives the same files again, and that of a case is in its folder") {
  const SampleCase folder;
  const fs::path file = folder / "state.h5";
  ok(folder, "config.xml --hematocrit 0.3 --checkpoint-every 1000");
  const std::string whole = readText(folder / "RBC.pos");
  fs::remove(folder / "RBC.pos");
  const Ran again = ok(folder, "--restart=state.h5");
  REQUIRE(readText(folder / "RBC.pos") == whole);
  REQUIRE_THAT(again.out, Contains("Continuing from state.h5"));
  REQUIRE_THAT(ended(folder, int(ExitCode::badInput), "config.xml --hematocrit 0.4 --restart state.h5").err,
               Contains("another problem"));
  REQUIRE_THAT(ended(folder, int(ExitCode::badInput), "--restart nowhere.h5").err,
               Contains("nowhere.h5: no such file"));
  writeText(file, "not HDF5");
  REQUIRE_THAT(ended(folder, int(ExitCode::badInput), "--restart state.h5").err,
               Contains("not a packMesh state"));
  ended(folder, int(ExitCode::usage), "check config.xml --restart state.h5");
}

TEST_CASE(
    "A state is written through a symbolic link, and if this fails the run fails after writing its cells") {
  const SampleCase folder;
  fs::create_directory(folder / "elsewhere");
  ok(folder, "config.xml --rbc 3 --state elsewhere/state.h5");
  fs::create_symlink("elsewhere/state.h5", folder / "state.h5");
  ok(folder, "config.xml --rbc 4 --state state.h5");
  CHECK(fs::is_symlink(folder / "state.h5"));
  CHECK(readStateHead(folder / "elsewhere/state.h5").cells == 4);
  CHECK_THAT(ended(folder, 5, "config.xml --rbc 5 --state /proc/state.h5").err, Contains("/proc"));
}

TEST_CASE("A result stays when a later run fails, whose checkpoint leads to the next result",
          "[executable]") {
  const TemporaryFolder folder;
  const fs::path result = folder / "s.h5", saved = folder / "s.checkpoint.h5";
  ok(folder, "20 20 20 --hematocrit 0.2 --state s.h5");
  CHECK(readStateHead(result).stage == "finished");
  CHECK(readStateHead(result).files.size() == 2);
  CHECK_FALSE(fs::exists(saved));
  const std::string before = readText(result) + positions(folder.path());
  CHECK_THAT(
      ended(folder, int(ExitCode::outOfReach), "20 20 20 --hematocrit 0.45 --max-iterations 5 --state s.h5")
          .out,
      Contains("To continue with higher limits: packMesh --restart s.checkpoint.h5"));
  CHECK((readText(result) + positions(folder.path()) == before));
  CHECK(readStateHead(saved).stage != "finished");
  // A run of something else leaves the checkpoint alone; the run that continues it removes it.
  CHECK_THAT(ok(folder, "20 20 20 --hematocrit 0.2 --seed 2 --state s.h5").out,
             Contains("s.checkpoint.h5 is the checkpoint of another run, and stays"));
  CHECK(fs::exists(saved));
  const std::string second = positions(folder.path());
  ok(folder, "--restart s.checkpoint.h5 --max-iterations 100000");
  CHECK_FALSE(fs::exists(saved));
  CHECK((positions(folder.path()) != second));
  CHECK(readStateHead(result).stage == "finished");
  const Ran named = ended(folder, int(ExitCode::cannotWrite), "20 20 20 --rbc 2 --state a.checkpoint.h5");
  CHECK_THAT(
      named.err,
      Contains("is the name of a checkpoint; the state of the result needs another one, such as a.h5"));
}

TEST_CASE("Files of the result before that are not replaced are renamed", "[executable]") {
  const TemporaryFolder folder;
  const fs::path platelets = folder / "PLT.pos";
  ok(folder, "20 20 20 --rbc 4 --plt 3 --state s.h5");
  const std::string before = readText(platelets);
  CHECK_THAT(ok(folder, "20 20 20 --rbc 5 --state s.h5").err,
             Contains("PLT.pos is of an earlier packing: renamed to ./PLT.pos.old"));
  CHECK_FALSE(fs::exists(platelets));
  CHECK((readText(folder / "PLT.pos.old") == before));
  // Of a species that now has no cells; a file without cells, as the plug-in leaves it, stays.
  writeText(platelets, before);
  ok(folder, "20 20 20 --rbc 5 --plt 0");
  CHECK_FALSE(fs::exists(platelets));
  writeText(platelets, "3\n");
  ok(folder, "20 20 20 --rbc 5 --plt 0");
  CHECK(fs::exists(platelets));
}

TEST_CASE("check notices files of two runs beside a state", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "20 20 20 --rbc 4 --plt 3 --output-dir other --seed 2");
  ok(folder, "20 20 20 --rbc 4 --plt 3 --state s.h5");
  CHECK_THAT(ok(folder, "check --box 20 20 20").err, !Contains("two runs"));
  fs::copy_file(folder / "other/RBC.pos", folder / "RBC.pos", fs::copy_options::overwrite_existing);
  CHECK_THAT(run(folder, "check --box 20 20 20").err,
             Contains("files of two runs: PLT.pos was written together with ./s.h5, RBC.pos not"));
}

TEST_CASE("The folder of a state is created") {
  const TemporaryFolder folder;
  REQUIRE(ok(folder, "20 20 20 --hematocrit 0.2 --checkpoint-every 1000 --output-dir a/b").err.empty());
  REQUIRE(readStateHead(folder / "a/b/state.h5").cells > 10);
}

TEST_CASE("A file that is not a state is not overwritten, which is reported before work begins", "[ranks]") {
  const SampleCase folder;
  const std::string config = readText(folder / "config.xml");
  fs::create_directory(folder / "folder.h5");
  REQUIRE(::mkfifo((folder / "pipe").c_str(), 0600) == 0);
  for (const char* name : {"config.xml", "folder.h5", "pipe", "RBC.pos", "cells.pov"}) {
    requireRefused(folder, {{std::string("config.xml --hematocrit 0.3 --state ") + name,
                             int(ExitCode::cannotWrite), name}});
  }
  REQUIRE_THAT(withExit(int(ExitCode::cannotWrite),
                        runProcess(folder, "config.xml --hematocrit 0.3 --state folder.h5", onRanks(2)))
                   .err,
               Contains("folder.h5"));
  REQUIRE_FALSE(fs::exists(folder / "RBC.pos"));
  REQUIRE(readText(folder / "config.xml") == config);
  // An older state gives way.
  ok(folder, "config.xml --hematocrit 0.2 --state s.h5");
  ok(folder, "config.xml --hematocrit 0.3 --state s.h5");
}

TEST_CASE("Invalid checkpoints and restarts are reported on several ranks, too", "[ranks]") {
  const TemporaryFolder folder;
  writeText(folder / "state.h5", "not HDF5");
  const std::string box = "30 30 30 --hematocrit 0.2 --restart state.h5", none = "not a packMesh state";
  requireRefused(folder, {{"--restart state.h5", 2, none},
                          {"--restart nowhere.h5", 2, "no such file"},
                          {box, 2, none},
                          {"30 30 30 --checkpoint-every 0", 1, "'--checkpoint-every'"},
                          {"--restart", 1, "--restart"}});
  for (const std::string& arguments : {std::string("--restart state.h5"), box}) {
    const Ran ran = runProcess(folder, arguments, onRanks(2));
    CAPTURE(arguments, ran.all());
    REQUIRE(ran.exitCode == int(ExitCode::badInput));
    REQUIRE_THAT(ran.all(), Contains(none));
  }
}
