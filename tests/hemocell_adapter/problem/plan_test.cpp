// SPDX-License-Identifier: AGPL-3.0-or-later
// The attempts of a run: with room between membranes and to the wall that nobody asked for, the largest there
// is, soft.
#include "hemocell_adapter/problem/plan.h"
#include "hemocell_adapter/base/messages.h"

#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

namespace {

std::vector<Clearances> levelsOf(const std::vector<std::string>& words,
                                 const std::string& program = "packMesh") {
  return clearanceLevels(planned(words, program));
}

Plan planFor(const std::vector<std::string>& words, Begin begin = Begin::anew) {
  const Problem problem = planned(words);
  LumenSample sample(problem);
  return planOf(problem, sample, begin);
}

/// "p" probe, "u" undeformed, "s" soft; capital letters: fewer cells are enough.
std::string lettersOf(const Plan& plan) {
  std::string text;
  for (const Rung& rung : plan.rungs) text += (rung.fewerCells ? "UPS" : "ups")[int(rung.cells)];
  return text;
}

double numberAfter(const std::string& text, const std::string& words) {
  const std::size_t at = text.find(words);
  REQUIRE(at != std::string::npos);
  return std::stod(text.substr(at + words.size()));
}

}  // namespace

TEST_CASE("Automatic clearances are proportional to the lattice spacing", "[clearances]") {
  const SampleCase folder;
  const std::string config = (folder / "config.xml").string();
  const auto pipe = levelsOf({config, "--hematocrit", "0.3"});
  CHECK(pipe.front().membranes == Approx(0.05));
  CHECK(pipe.front().wall == Approx(0.5));
  CHECK(pipe.back().membranes == 0.0);
  CHECK(pipe.back().wall == 0.0);
  for (std::size_t i = 1; i < pipe.size(); ++i) CHECK(pipe[i].wall < pipe[i - 1].wall);

  const auto coarse = levelsOf({"30", "30", "30", "--rbc", "10", "--walls", "xyz", "--dx", "1"});
  CHECK(coarse.front().membranes == Approx(0.1));
  CHECK(coarse.front().wall == Approx(1.0));

  const auto open = levelsOf({"30", "30", "30", "--rbc", "10"});
  CHECK(open.front().wall == Approx(0.025));  // cells beyond the face then are as far as others

  const auto periodic = levelsOf({"30", "30", "30", "--rbc", "10", "--ends", "periodic"});
  CHECK(periodic.front().membranes == Approx(0.05));
  CHECK(periodic.front().wall == 0.0);
}

TEST_CASE("Requested clearances replace the automatic ones", "[clearances]") {
  const auto both =
      levelsOf({"30", "30", "30", "--rbc", "10", "--clearance", "0.2", "--wall-clearance", "0"});
  REQUIRE(both.size() == 1);
  CHECK(both.front().membranes == 0.2);
  CHECK(both.front().wall == 0.0);
  for (const Clearances& level : levelsOf({"30", "30", "30", "--rbc", "10", "--clearance", "0.2"}))
    CHECK(level.membranes == 0.2);
  const auto automatic = levelsOf({"30", "30", "30", "--rbc", "10", "--clearance", "auto"});
  CHECK(automatic.front().membranes == Approx(0.05));
  const auto packCells = levelsOf({"30", "30", "30", "--rbc", "10"}, "packCells");
  REQUIRE(packCells.size() == 1);
  CHECK(packCells.front().membranes == 0.0);
}

TEST_CASE("Growth keeps the same automatic clearances, but not with escapes", "[clearances]") {
  const std::vector<std::string> box = {"30", "30", "30", "--rbc", "10", "--walls", "xyz", "--method", "cat"};
  if (!hasCat()) {
    CHECK_THROWS_WITH(levelsOf(box), Contains(heading("method") + ": this packMesh was built without 'cat'"));
    return;
  }
  const auto levels = levelsOf(box);
  REQUIRE(levels.size() == 4);
  CHECK(levels.front().membranes == Approx(0.05));
  CHECK(levels.front().wall == Approx(0.5));
  auto escaping = box;
  escaping.push_back("--escape");
  CHECK(levelsOf(escaping).size() == 1);

  CHECK(planFor(box).rungs.front().most == 100);

  const TemporaryFolder folder;
  const Ran grown = ok(folder, "25 25 25 --hematocrit 0.2 --method cat");
  CHECK_THAT(grown.out, Contains("Clearance kept: 0.05 µm between membranes, 0.025 µm to the wall"));
  CHECK(numberAfter(grown.out, "minimum gap ") >= 0.05);
  ok(folder, "check --box 25 25 25 --clearance 0.05");
}

TEST_CASE("Clearances are tried one after another, the last ones without limits of their own",
          "[clearances]") {
  const std::vector<std::string> box = {"30", "30", "30", "--rbc", "100", "--walls", "xyz"};
  const Plan plan = planFor(box);
  CHECK(lettersOf(plan) == "uuuU");
  CHECK_FALSE(plan.widens);
  const Rung &first = plan.rungs.front(), &last = plan.rungs.back();
  CHECK(first.most == 600);
  CHECK(first.someCloser);
  CHECK(last.most == 0);
  for (std::size_t i = 0; i < plan.rungs.size(); ++i) CHECK(plan.rungs[i].otherwise == i + 1);
  CHECK(plan.lines(false).front() ==
        "1. undeformed cells, 0.05 µm between membranes, 0.5 µm to the wall, at most 600 sweeps");
  CHECK(secondsOf(first, 10.0, 2.0) == 2.0);
  CHECK(secondsOf(last, 10.0, 2.0) == 8.0);
  CHECK(secondsOf(last, 10.0, 12.0) == Limits::leastSeconds);
  CHECK(secondsOf(last, 0.0, 12.0) == 0.0);

  auto limited = box;
  limited.insert(limited.end(), {"--max-iterations", "50", "--max-time", "9"});
  CHECK(planFor(limited).rungs.front().most == 50);
  CHECK_THAT(planFor(limited).lines(true).front(),
             EndsWith("at most 50 sweeps, 25 % of the time that is left"));
}

TEST_CASE("Cells are soft where undeformed ones do not fit", "[soft]") {
  const std::vector<std::string> box = {"14",           "14",  "14",          "--ends", "periodic",
                                        "--hematocrit", "0.5", "--clearance", "0"};
  const auto with = [&](std::initializer_list<std::string> more) {
    std::vector<std::string> all = box;
    all.insert(all.end(), more);
    return all;
  };
  const Plan soft = planFor(with({"--soft"}));
  CHECK(lettersOf(soft) == "pus");
  CHECK(soft.rungs[0].otherwise == 2);
  CHECK(soft.rungs[2].most == 20000);
  CHECK(planFor(with({"--soft", "--max-iterations", "50000"})).rungs[2].most == 50000);
  CHECK(lettersOf(planFor(with({"--soft", "--best-effort"}))) == "puSU");
  CHECK(lettersOf(planFor(with({"--soft"}), Begin::soft)) == "s");
  CHECK(lettersOf(planFor(with({"--soft"}), Begin::undeformed)) == "us");

  const Plan ifNeeded = planFor(with({"--soft=auto"}));
  CHECK(lettersOf(ifNeeded) == "us");
  CHECK(ifNeeded.rungs[0].until == 0.5);
  CHECK(ifNeeded.rungs[0].most == 10000);
  CHECK_FALSE(ifNeeded.rungs[0].savesStates);
  auto denser = with({"--soft=auto"});
  denser[6] = "0.7";
  CHECK(lettersOf(planFor(denser)) == "pus");
}

TEST_CASE("Cells that are all rigid are undeformed", "[soft]") {
  CHECK(lettersOf(planFor({"14", "14", "14", "--rbc", "0", "--plt", "3", "--soft", "--rigid", "PLT",
                           "--clearance", "0"})) == "uuuU");
}

TEST_CASE("Soft cells are tried with room at the wall first", "[soft]") {
  const Plan tube =
      planFor({"--cylinder", "x", "4", "20", "--rbc", "2", "--ends", "periodic", "--soft", "--dx", "0.5"},
              Begin::soft);
  REQUIRE(lettersOf(tube) == "ss");
  CHECK(tube.rungs[0].clearances.wall == Approx(0.5 * std::sqrt(0.5)));
  CHECK(tube.rungs[0].most == 4000);
  CHECK_FALSE(tube.rungs[0].savesFailed);
  CHECK(tube.rungs[1].lessRoomThan == tube.rungs[0].clearances.wall);
  CHECK(tube.rungs[1].clearances.wall == 0.0);
}

TEST_CASE("The largest clearance is looked for to two per cent", "[clearances]") {
  CHECK(planFor({"20", "20", "20", "--rbc", "9", "--clearance", "max"}).widens);
  double succeeded = 0.05, failed = 0.0;
  int attempts = 0;
  while (const auto wider = widerClearance(succeeded, failed)) {
    (*wider <= 0.3 ? succeeded : failed) = *wider;
    REQUIRE(++attempts < 12);
  }
  CHECK(succeeded <= 0.3);
  CHECK(succeeded >= 0.98 * 0.3 - 0.001);
  CHECK(widerClearance(0.0, 0.0) == 0.016);
  CHECK(widerRung(planned({"20", "20", "20", "--rbc", "9"}), {}).most == 600);
  CHECK(widerRung(planned({"20", "20", "20", "--rbc", "9", "--max-iterations", "14000"}), {}).most == 14000);
}

TEST_CASE("A box is packed with cells that HemoCell keeps, and with clearance between them", "[clearances]") {
  const TemporaryFolder folder;
  const Ran packed = ok(folder, "25 25 25 --hematocrit 0.3");
  CHECK_THAT(packed.out, Contains("HemoCell keeps 62 of 62 cells"));
  CHECK_THAT(packed.out, Contains("Clearance kept: 0.05 µm between membranes, 0.025 µm to the wall"));
  CHECK(numberAfter(packed.out, "minimum gap ") >= 0.05);
  CHECK_THAT(packed.all(), !Contains("HemoCell would keep"));
  ok(folder, "check --box 25 25 25 --clearance 0.05");
}

TEST_CASE("A periodic box gives a warning about the cells that HemoCell would keep", "[clearances]") {
  const TemporaryFolder folder;
  for (const char* program : {"packMesh", "packCells"}) {
    const Ran packed = ended(folder, 0,
                             std::string("25 25 25 --hematocrit 0.3") +
                                 (std::string(program) == "packMesh" ? " --ends periodic" : ""),
                             program);
    CHECK_THAT(packed.out, Contains("periodic box"));
    CHECK_THAT(packed.err, Contains("HemoCell would keep") && Contains("a hematocrit of 0."));
  }
}

TEST_CASE("The automatic clearance is reduced at high hematocrit, requested ones are not", "[clearances]") {
  const TemporaryFolder folder;
  const std::string dense = "24 24 24 --hematocrit 0.585 --plt_ratio 0 --ends periodic ";
  const Ran packed = ok(folder, dense);
  CHECK(numberAfter(packed.out, "minimum gap ") < 0.05);
  ended(folder, 3, dense + "--clearance 0.3 --max-iterations 50");
}

TEST_CASE("A run that tried an automatic clearance in vain reports this", "[clearances][long]") {
  const TemporaryFolder folder;
  const std::string dense = "24 24 24 --hematocrit 0.605 --plt_ratio 0 --ends periodic ";
  CHECK_THAT(ok(folder, dense).out, Contains("Clearance kept: none beyond the minimum gaps above\n"));
  CHECK_THAT(run(folder, "24 24 24 --rbc 9 --clearance 0 --wall-clearance 0").out,
             !Contains("Clearance kept"));
  CHECK_THAT(run(folder, "24 24 24 --rbc 9", "packCells").out, !Contains("Clearance kept"));
}

TEST_CASE("The largest clearance can be requested", "[clearances]") {
  const TemporaryFolder folder;
  const Ran packed = ok(folder, "20 20 20 --rbc 12 --clearance max");
  CHECK(numberAfter(packed.out, "Clearance kept: ") > 0.2);
}

TEST_CASE("The requested clearances are kept between cells and to the wall", "[executable]") {
  const SampleCase folder;
  const Ran packed = ok(folder, "config.xml --hematocrit 0.25 --clearance 0.1 --wall-clearance 0.4");
  const auto gapAfter = [](const std::string& text, const std::string& words) {
    const std::size_t at = text.find(words);
    REQUIRE(at != text.npos);
    return std::stod(text.substr(at + words.size()));
  };
  CHECK(gapAfter(packed.out, "minimum gap ") >= 0.1);
  CHECK(gapAfter(packed.out, "to the wall ") >= 0.4);
  CHECK(gapAfter(packed.out, "to the wall ") < 0.6);

  const Ran checked = ok(folder, "check config.xml");
  CHECK(gapAfter(checked.out, "Minimum gap to the wall: ") == gapAfter(packed.out, "to the wall "));
}

TEST_CASE("A cell that fits only without the automatic clearance is packed by either method",
          "[executable]") {
  const TemporaryFolder folder;
  for (const char* method : {"relaxation", "cat"}) {
    if (method == std::string("cat") && !hasCat()) continue;
    ok(folder, std::string("--cylinder x 1.4 6 --plt 1 --method ") + method);
  }
}
