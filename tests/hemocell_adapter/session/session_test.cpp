// SPDX-License-Identifier: AGPL-3.0-or-later
#include <nlohmann/json.hpp>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/output_plan.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/session/session.h"
#include "hemocell_adapter/settings/command_line.h"
#include "packMesh/core/error.h"
#include "packMesh/packing/state_file.h"
#include "packMesh/soft/soft_engine.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;
using namespace packmesh::hemocell;

TEST_CASE("A problem that does not fit into memory is rejected with figures") {
  const Communicator alone;
  REQUIRE(availableMemory(alone) > 1000.0 * leastOfDeformedCell);
  REQUIRE_NOTHROW(requireMemory(1000, alone));
  REQUIRE_THROWS_AS(requireMemory(std::int64_t(1) << 60, alone), InputError);
  REQUIRE_THROWS_WITH(
      requireMemory(1'000'000'000'000'000, alone),
      Contains("not enough memory: 1000000000000000 cells take at least 9e+08 GB on each of 1 rank") &&
          Contains(" GB are left for each"));
  REQUIRE_NOTHROW(requireMemory(1000, alone, leastOfDeformedCell));
  REQUIRE_THROWS_WITH(requireMemory(1'000'000'000'000, alone, leastOfDeformedCell),
                      Contains("1000000000000 deformed cells take at least 6e+07 GB"));
}

// A box repeated, with the real executable.

using namespace packmesh;
using namespace packmesh::test;

TEST_CASE("Columns are repeated, and the state of the result is that of the large box", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "16 18 20 --ends periodic --rbc 12 --order columns --tile 2 1 1 --state s.h5");
  CHECK(readPos(folder / "RBC.pos").size() == 24);
  CHECK_THAT(ok(folder, "check --box 32 18 20 --ends periodic --start s.h5").out, Contains("RBC: 24 cells"));
}

TEST_CASE("A repeated box keeps its hematocrit", "[executable]") {
  const TemporaryFolder folder;
  const Ran ran = ok(folder,
                     "16 18 20 --ends periodic --hematocrit 0.3 --plt_ratio 0.1 --tile 2 1 3 --export csv "
                     "--report report.json");
  const int cells = 6 * 21;  // 0.3 · 16 · 18 · 20 / 81.1163 = 21.3
  CHECK(readPos(folder / "RBC.pos").size() == cells);
  ok(folder, "check --box 32 18 60 --ends periodic");
  CHECK_THAT(ran.out, Contains("periodic box 32 x 18 x 60"));
  // Images of one cell follow each other.
  const auto lines = readPos(folder / "RBC.pos");
  CHECK(lines[1].position == lines[0].position + Vec3(0, 0, 20));
  CHECK(lines[1].angles == lines[0].angles);
  const auto report = readJson(folder / "report.json");
  CHECK(report["species"][0]["placed"] == cells);
  const auto& repeated = report["repeated"];
  CHECK(repeated["times"] == nlohmann::json({2, 1, 3}));
  CHECK(repeated["boxSize"] == nlohmann::json({16.0, 18.0, 20.0}));
  CHECK(repeated["cells"] == 23);
  CHECK(repeated["hematocrit"] == 0.3);
  CHECK(repeated["certificate"]["clean"] == true);
  CHECK(repeated["certificate"]["minimumGap"].get<double>() ==
        Approx(report["certificate"]["minimumGap"].get<double>()));
  CHECK(repeated["statistics"]["sweeps"] > 0);
  ok(folder, "16 18 20 --ends periodic --rbc 3 --walls x --tile 1 2 1");
}

// Sessions, without a process: what they make, hand out and refuse.

namespace {

/// A session of a request, which prints nothing.
class Quiet {
 public:
  explicit Quiet(const std::vector<std::string>& words, const Hooks& hooks = {})
      : completed(requestToPack(continued(parseCommandLine("packMesh", words).request))),
        output(outputsToPack(completed)),
        session(returnedToPython, hooks, ranks) {
    log::setLevel(log::Level::silent);
  }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;
  ~Quiet() { log::setLevel(log::Level::normal); }

  Packing pack() { return session.pack(session.prepare(completed), output); }

  /// The failure of a packing that is not handed out.
  AgreedFailure failure() {
    try {
      pack();
    } catch (const AgreedFailure& failure) {
      return failure;
    }
    FAIL("it was packed");
    throw;
  }

  const CompletedRequest completed;
  const OutputRequest output;
  const Communicator ranks;
  Session session;
};

}  // namespace

TEST_CASE("A session hands out a packing that is certified, counted and kept by HemoCell", "[session]") {
  Quiet quiet({"16", "16", "16", "--rbc", "6", "--plt", "2", "--seed", "3"});
  const Packing packing = quiet.pack();
  CHECK(packing.outcome == Outcome::certified);
  CHECK(packing.certificate.clean());
  CHECK(packing.tally.counts == std::vector<std::int64_t>{6, 2});
  CHECK(packing.kept.kept == packing.tally.counts);
  CHECK(packing.kept.reasons.empty());
  CHECK_FALSE(packing.state);
  CHECK_FALSE(packing.before);
  CHECK(packing.packed.clearances.membranes > 0.0);  // more than demanded, where that is possible
}

TEST_CASE("A packing has its state if one is requested, which is not written by the session", "[session]") {
  const test::TemporaryFolder folder;
  Quiet quiet({"16", "16", "16", "--rbc", "4", "--state", (folder / "new" / "s.h5").string()});
  const Packing packing = quiet.pack();
  CHECK(packing.state);
  CHECK(std::filesystem::is_directory(folder / "new"));
  CHECK(std::filesystem::is_empty(folder / "new"));
}

TEST_CASE("A packing that is repeated has the one before, and is of a larger box", "[session]") {
  Quiet quiet({"12", "12", "12", "--rbc", "3", "--ends", "periodic", "--tile", "2", "1", "1"});
  const Packing packing = quiet.pack();
  REQUIRE(packing.before);
  CHECK(packing.before->cellCount == 3);
  CHECK(packing.cellCount == 6);
  CHECK(packing.problem->lumen.container->bounds().hi.x() == Approx(24.0));
}

TEST_CASE("With a profile a session packs before it hands out a problem", "[session]") {
  Quiet quiet(
      {"--cylinder", "x", "9", "30", "--ends", "periodic", "--hematocrit", "0.2", "--profile", "developed"});
  const Problem first = problemToPack(quiet.completed);
  const std::shared_ptr<const Problem> prepared = quiet.session.prepare(quiet.completed);
  REQUIRE(prepared->layout.profile);
  CHECK(prepared->layout.profile->species[0].weight != first.layout.profile->species[0].weight);
  CHECK(prepared->mostCells() == first.mostCells());
}

TEST_CASE("What cannot be packed is not handed out, unless fewer cells are enough", "[session]") {
  const std::vector<std::string> dense = {"12",          "12", "12",     "--hematocrit", "0.68",
                                          "--plt_ratio", "0",  "--ends", "periodic",     "--max-iterations",
                                          "60"};
  const AgreedFailure failure = Quiet(dense).failure();
  CHECK(failure.code() == ExitCode::outOfReach);
  CHECK_THAT(failure.what(), Contains("not feasible within the limits") && Contains("no cells are returned"));
  std::vector<std::string> content = dense;
  content.push_back("--best-effort");
  Quiet quiet(content);
  const Packing packing = quiet.pack();
  CHECK(packing.outcome == Outcome::outOfReach);
  CHECK(packing.cellCount > 0);
  CHECK(packing.cellCount < packing.problem->mostCells());
  CHECK(packing.certificate.clean());
}

TEST_CASE("An interrupted session hands out nothing", "[session]") {
  Hooks hooks;
  hooks.interrupted = [] { return true; };
  const AgreedFailure failure = Quiet({"16", "16", "16", "--rbc", "6"}, hooks).failure();
  CHECK(failure.code() == ExitCode::interrupted);
}

TEST_CASE("A failed packing names the limit with which a restart gets farther", "[session]") {
  const test::TemporaryFolder folder;
  const auto raised = [&](const std::string& hematocrit, const std::vector<std::string>& more) {
    std::vector<std::string> asked = {"8",
                                      "8",
                                      "8",
                                      "--ends",
                                      "periodic",
                                      "--plt_ratio",
                                      "0",
                                      "--hematocrit",
                                      hematocrit,
                                      "--state",
                                      (folder / "s.h5").string()};
    asked.insert(asked.end(), more.begin(), more.end());
    Quiet quiet(asked);
    static_cast<void>(quiet.failure());
    CHECK(quiet.session.stateSaved());
    return quiet.session.raise();
  };
  const std::string iterations = named("max-iterations", "NUMBER");
  CHECK(raised("0.75", {"--soft", "--max-iterations", "20"}) == iterations);
  CHECK(raised("0.65", {"--max-iterations", "5"}) == iterations);
  // At rest, with more force than is allowed, which the message names.
  CHECK(raised("0.75", {"--soft", "--max-force", "0.5"}).empty());
}

TEST_CASE("Soft cells whose certificate is interrupted are certified when the run continues", "[session]") {
  const test::TemporaryFolder folder;
  const std::string state = (folder / "s.h5").string(), checkpoint = folder / "s.checkpoint.h5";
  const std::vector<std::string> asked = {"10",   "10",     "10",      "--ends", "periodic", "--hematocrit",
                                          "0.73", "--soft", "--state", state,    "--seed",   "3"};
  std::int64_t polls = 0, most = std::numeric_limits<std::int64_t>::max();
  Hooks hooks;
  hooks.interrupted = [&] { return ++polls > most; };
  hooks.progress = [](const Progress&, ProgressLog&) {};
  const Packing whole = Quiet(asked, hooks).pack();
  most = std::exchange(polls, 0) - 2;  // the last ones are those of the certificate
  CHECK_THAT(Quiet(asked, hooks).failure().what(), Contains("restart from " + checkpoint));
  CHECK(readStateHead(checkpoint).stage == softCellsStage);
  const Packing rest = Quiet({"--restart", checkpoint}).pack();
  REQUIRE(rest.cellCount == whole.cellCount);
  for (std::size_t i = 0; i < whole.cells.size(); ++i)
    CHECK(rest.problem->shapes[rest.cells[i].shape]->mesh().vertices ==
          whole.problem->shapes[whole.cells[i].shape]->mesh().vertices);
}

TEST_CASE("The end of preparation owns what it needs", "[session]") {
  std::function<void()> unlimited, limited, interrupted;
  {
    const Delivery delivery = writtenToFiles;
    unlimited = endOfPreparation(0.0, delivery);
    limited = endOfPreparation(1e-9, delivery);
    interrupted = endOfPreparation(0.0, delivery, [] { return true; });
  }
  CHECK_NOTHROW(unlimited());
  CHECK_THROWS_WITH(limited(), Contains("was reached before packing began; nothing was written"));
  CHECK_THROWS_WITH(interrupted(), Contains("interrupted: nothing was written"));
}
