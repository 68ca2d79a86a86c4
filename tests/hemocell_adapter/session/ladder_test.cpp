// SPDX-License-Identifier: AGPL-3.0-or-later
// The attempts of a run, each by itself and all of them.
#include "hemocell_adapter/session/ladder.h"

#include <memory>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/problem/forecast.h"
#include "packMesh/soft/soft_engine.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

namespace {

std::shared_ptr<const Problem> problemShared(const std::vector<std::string>& words) {
  return std::make_shared<const Problem>(planned(words));
}

/// The attempts at what a command line asks for; prints nothing as long as it exists.
struct Attempts {
  explicit Attempts(const std::vector<std::string>& words, Hooks itsHooks = {})
      : problem(problemShared(words)), hooks(std::move(itsHooks)) {
    log::setLevel(log::Level::silent);
  }
  ~Attempts() { log::setLevel(log::Level::normal); }
  Attempts(const Attempts&) = delete;
  Attempts& operator=(const Attempts&) = delete;

  const std::shared_ptr<const Problem> problem;
  const Hooks hooks;
  const OutputRequest output;
  const Timer timer;
  LumenSample sample{*problem};
  Ladder ladder{problem, output, sample, hooks, timer};
};

}  // namespace

TEST_CASE("A packing has its problem, and the parts with the clearances that its certificate refers to",
          "[attempts]") {
  Attempts of({"16", "16", "16", "--rbc", "6", "--seed", "3"});
  const Packing packing = of.ladder.climb();
  CHECK(packing.problem == of.problem);
  CHECK(packing.outcome == Outcome::certified);
  CHECK(packing.clearance > of.problem->demanded.membranes);
  CHECK(packing.packed.clearances.membranes == packing.clearance);
  CHECK(packing.packed.clearances.wall == packing.wallClearance);
  CHECK(packing.certificate.minimumGap >= packing.clearance);
  CHECK(packing.packed.parts.size() == packing.counts.size());
  CHECK_FALSE(packing.state);
  CHECK_FALSE(of.ladder.savedAny());
}

TEST_CASE("One attempt packs with the clearances that it is given, or says that they are impossible",
          "[attempts]") {
  Attempts of({"16", "16", "16", "--rbc", "4", "--walls", "xyz"});
  Rung rung;
  rung.clearances = {0.0, 7.9};
  CHECK_FALSE(of.ladder.attempt(rung));
  rung.clearances = {0.2, 0.1};
  const auto packed = of.ladder.attempt(rung);
  REQUIRE(packed);
  CHECK(packed->outcome == Outcome::certified);
  CHECK(packed->clearance == 0.2);
  CHECK(packed->wallClearance == 0.1);
}

TEST_CASE("A probe has no cells, and soft cells have their own problem", "[attempts]") {
  for (const auto& [hematocrit, easy] : {std::pair{"0.3", true}, {"0.7", false}}) {
    Attempts of(
        {"10", "10", "10", "--ends", "periodic", "--hematocrit", hematocrit, "--plt_ratio", "0", "--soft"});
    Rung probe;
    probe.cells = Rung::Cells::probe;
    const auto tried = of.ladder.attempt(probe);
    REQUIRE(tried);
    CHECK(tried->outcome == (easy ? Outcome::certified : Outcome::outOfReach));
    CHECK(tried->cellCount == 0);
    const Packing packing = of.ladder.climb();
    CHECK(packing.outcome == Outcome::certified);
    CHECK((packing.problem == of.problem) == easy);
    CHECK(packing.problem->hasDeformed() != easy);
  }
}

TEST_CASE("Soft cells that are out of reach are none, or fewer", "[attempts]") {
  const std::vector<std::string> dense = {
      "10",   "10",     "10",          "--ends", "periodic",         "--hematocrit",
      "0.95", "--soft", "--plt_ratio", "0",      "--max-iterations", "150"};
  Attempts all(dense);
  const Packing none = all.ladder.climb();
  CHECK(none.outcome == Outcome::outOfReach);
  CHECK(none.cellCount == 0);
  CHECK_THAT(none.whyFewer, Contains("the cells had grown to 0."));
  std::vector<std::string> content = dense;
  content.push_back("--best-effort");
  Attempts some(content);
  const Packing fewer = some.ladder.climb();
  CHECK(fewer.cellCount > 0);
  CHECK(fewer.cellCount < some.problem->mostCells());
  CHECK(fewer.certificate.clean());
  CHECK_THAT(fewer.whyFewer, Contains("; "));
}

TEST_CASE("Cells are undeformed where they fit beside fixed soft ones", "[attempts]") {
  const TemporaryFolder folder;
  ok(folder, "10 10 10 --ends periodic --hematocrit 0.7 --plt_ratio 0 --soft --state s.h5");
  const std::vector<std::string> asked = {
      "10", "10", "10", "--ends", "periodic", "--fixed", (folder.path() / "s.h5").string(), "--plt", "4"};
  const std::vector<std::vector<std::string>> ways = {
      {}, {"--soft"}, {"--soft=auto"}, {"--soft", "--rigid", "PLT"}};
  for (const auto& way : ways) {
    std::vector<std::string> words = asked;
    words.insert(words.end(), way.begin(), way.end());
    Attempts of(words);
    const Packing packing = of.ladder.climb();
    CHECK(packing.outcome == Outcome::certified);
    CHECK(packing.problem == of.problem);
    CHECK(packing.cellCount == of.problem->mostCells());
    for (const PlacedCell& cell : packing.cells)
      if (of.problem->species[cell.species].name == "PLT") CHECK(cell.shape == cell.species);
  }
}

TEST_CASE("Progress of soft cells tells how large they are, and no time that nobody knows", "[attempts]") {
  const auto problem = problemShared({"16", "16", "16", "--rbc", "4", "--soft"});
  LumenSample sample(*problem);
  ProgressLog progress(*problem, sample);
  for (const double scale : {0.8, 1.0}) {
    const std::string text = progress.text({softCellsStage, 40, scale, 0.0, 0}, 40.0);
    CHECK_THAT(text, Contains("soft cells: iteration 40") && Contains("; 40 s") && !Contains("left"));
    CHECK_THAT(text, Contains(scale < 1.0 ? "at scale 0.80" : "coming to rest"));
  }
}

TEST_CASE("An attempt that is interrupted has no cells", "[attempts]") {
  Hooks hooks;
  hooks.interrupted = [] { return true; };
  for (const bool soft : {false, true}) {
    std::vector<std::string> words = {"16", "16", "16", "--rbc", "4"};
    if (soft) words.push_back("--soft");
    Attempts of(words, hooks);
    const Packing packing = of.ladder.climb();
    CHECK(packing.outcome == Outcome::interrupted);
    CHECK(packing.cells.empty());
  }
}
