// SPDX-License-Identifier: AGPL-3.0-or-later
// Room between membranes and to the wall that nobody asked for, and the largest there is.
#include "hemocell_adapter/problem/clearances.h"
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

/// Packs what a rule allows, and remembers what it was asked.
struct Packer {
  std::function<Outcome(const Clearances&)> rule;
  std::vector<Clearances> tried = {};
  std::vector<AttemptLimits> limits = {};
  double seconds = 0.0;

  PackingResult pack(const Request& request, const std::vector<Clearances>& levels, std::size_t first = 0) {
    return packWithClearances(
        request, request, levels, first, 1000, [this] { return seconds; },
        [this](const Clearances& c, const AttemptLimits& l) {
          tried.push_back(c);
          limits.push_back(l);
          seconds += 1.0;
          PackingResult result;
          result.outcome = rule(c);
          result.clearance = c.membranes;
          result.wallClearance = c.wall;
          return std::optional<PackingResult>(std::move(result));
        });
  }
};

const std::vector<Clearances> threeLevels = {{0.05, 0.5}, {0.025, 0.25}, {0.0, 0.0}};

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

  Request request;
  request.method = Method::cat;
  Packer packer{[](const Clearances& c) { return c.wall < 0.3 ? Outcome::certified : Outcome::outOfReach; }};
  CHECK(packer.pack(request, threeLevels).wallClearance == 0.25);
  CHECK(packer.limits[0].maxSweeps == 100);

  const TemporaryFolder folder;
  const Ran grown = ok(folder, "25 25 25 --hematocrit 0.2 --method cat");
  CHECK_THAT(grown.out, Contains("Clearance kept: 0.05 µm between membranes, 0.025 µm to the wall"));
  CHECK(numberAfter(grown.out, "minimum gap ") >= 0.05);
  ok(folder, "check --box 25 25 25 --clearance 0.05");
}

TEST_CASE("Clearance levels are tried until one is certified, the last one without its own limits",
          "[clearances]") {
  Request request;
  Packer packer{[](const Clearances& c) { return c.wall < 0.3 ? Outcome::certified : Outcome::outOfReach; }};
  const PackingResult packing = packer.pack(request, threeLevels);
  CHECK(packing.wallClearance == 0.25);
  REQUIRE(packer.tried.size() == 2);
  CHECK_FALSE(packer.limits[0].fewerCells);
  CHECK(packer.limits[0].maxSweeps > 0);

  Packer hard{[](const Clearances&) { return Outcome::outOfReach; }};
  request.maxSeconds = 10.0;
  const PackingResult fewer = hard.pack(request, threeLevels);
  CHECK(fewer.outcome == Outcome::outOfReach);
  REQUIRE(hard.tried.size() == 3);
  CHECK(hard.limits[0].maxSeconds < 3.0);
  CHECK(hard.limits[2].maxSweeps == 0);
  CHECK(hard.limits[2].maxSeconds == Approx(8.0));
  CHECK(hard.limits[2].fewerCells);

  Packer stopped{[](const Clearances&) { return Outcome::interrupted; }};
  CHECK(stopped.pack(request, threeLevels).outcome == Outcome::interrupted);
  CHECK(stopped.tried.size() == 1);

  Packer continued{[](const Clearances&) { return Outcome::certified; }};
  CHECK(continued.pack(request, threeLevels, 1).wallClearance == 0.25);
}

TEST_CASE("The largest clearance is found to two per cent, or to what the time limit permits",
          "[clearances]") {
  Request request;
  request.largestClearance = true;
  Packer packer{
      [](const Clearances& c) { return c.membranes <= 0.3 ? Outcome::certified : Outcome::outOfReach; }};
  const PackingResult packing = packer.pack(request, threeLevels);
  CHECK(packing.outcome == Outcome::certified);
  CHECK(packing.clearance <= 0.3);
  CHECK(packing.clearance >= 0.98 * 0.3 - 0.001);
  CHECK(packing.wallClearance == 0.5);
  CHECK(packer.tried.size() < 12);
  CHECK(packer.limits.back().maxSweeps == 600);

  Packer patient{packer.rule};
  request.maxIterations = 14000;
  patient.pack(request, threeLevels);
  CHECK(patient.limits.back().maxSweeps == 14000);

  Packer hurried{packer.rule};
  request.maxSeconds = 3.0;
  const PackingResult some = hurried.pack(request, threeLevels);
  CHECK(some.outcome == Outcome::certified);
  CHECK(hurried.tried.size() == 3);
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
