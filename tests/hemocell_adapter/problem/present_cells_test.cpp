// SPDX-License-Identifier: AGPL-3.0-or-later
// Cells that are there already, with the real executable.
#include <algorithm>
#include <map>
#include <set>

#include "tests/hemocell_adapter/refusal.h"
#include "tests/support/catch.h"

using namespace packmesh::test;
namespace fs = std::filesystem;

namespace {

std::set<std::string> linesOf(const fs::path& file) {
  std::istringstream in(readText(file));
  std::set<std::string> lines;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) lines.insert(line);
  return lines;
}

bool holdsAll(const std::set<std::string>& all, const std::set<std::string>& some) {
  return std::includes(all.begin(), all.end(), some.begin(), some.end());
}

}  // namespace

TEST_CASE("Fixed cells keep their lines while others are added", "[executable]") {
  const SampleCase folder;
  ok(folder, "config.xml --hematocrit 0.2 --plt_ratio 0");
  const auto red = linesOf(folder / "RBC.pos");
  const Ran added = ok(folder, "config.xml --fixed RBC.pos --plt 20");
  CHECK(linesOf(folder / "RBC.pos") == red);
  CHECK(linesOf(folder / "PLT.pos").size() == 20);
  CHECK_THAT(added.out,
             Contains("RBC: " + std::to_string(red.size()) + " of them fixed at their positions in RBC.pos"));
  ok(folder, "check config.xml");
  // A higher hematocrit around them, by the configuration.
  fs::rename(folder / "RBC.pos", folder / "there.pos");
  writeText(folder / "config.xml",
            configXml(sampleDomain,
                      "<packing> <hematocrit> 0.24 </hematocrit> <species name=\"RBC\" "
                      "fixed=\"there.pos\"/> </packing>"));
  ok(folder, "config.xml");
  const auto more = linesOf(folder / "RBC.pos");
  CHECK(more.size() >= red.size() + 3);
  CHECK(holdsAll(more, red));
  requireRefused(folder, {{"config.xml --hematocrit 0.1", 2, "fixed cells, but only"}});
}

TEST_CASE("Fixed cells in invalid positions are rejected with their number", "[executable]") {
  const SampleCase folder;
  writeText(folder / "WBC.xml", cellXml("WBC", 4.0, 600, ""));
  const std::string asked = "config.xml --rbc 3 --fixed ";
  const auto cells = [](const std::string& text) {
    return [=](const fs::path& in) { writeText(in / "WBC.pos", text); };
  };
  requireRefused(
      folder,
      {{asked + "WBC.pos", 2, "cell 1 of 'WBC' and cell 2 of 'WBC', which stay where they are, overlap",
        cells("2\n12 7 7 0 0 0\n12 7.5 7 0 0 0\n")},
       {asked + "WBC.pos", 2, "cell 1 of 'WBC', which stays where it is,", cells("1\n12 1 7 0 0 0\n")},
       {asked + "none.pos", 2, "none.pos: no such file"},
       {"config.xml --rbc 3 --wbc 1", 2, "<InnerEdges> links the vertices 3 and 641; the last one is ",
        [](const fs::path& in) {
          writeText(
              in / "WBC.xml",
              cellXml("WBC", 4.0, 200,
                      "<kLink> 15 </kLink><kBend> 80 </kBend><kVolume> 20 </kVolume><kArea> 5 </kArea>"
                      "<kInnerRigid> 75 </kInnerRigid><kCytoskeleton> 25 </kCytoskeleton><coreRadius> 2e-6 "
                      "</coreRadius><InnerEdges><Edge> 3 641 </Edge></InnerEdges>"));
        }}});
}

TEST_CASE("Cells beyond the number that a file announces are ignored, as by HemoCell", "[executable]") {
  const TemporaryFolder folder;
  // The second one overlaps the first.
  writeText(folder / "RBC.pos", "1\n8 8 8 0 0 0\n8 8 9 0 0 0\n");
  const Ran checked = ok(folder, "check --box 16 16 16");
  CHECK_THAT(checked.out, Contains("RBC: 1 cells") && Contains("Verdict: clean"));
  CHECK_THAT(checked.err, Contains("announces 1 cell, but 2 lines follow"));
  for (const char* option : {"--fixed", "--start"}) {
    CHECK_THAT(ok(folder, std::string("16 16 16 --rbc 4 --output-dir packed ") + option + " RBC.pos").err,
               Contains("announces 1 cell, but 2 lines follow"));
  }
  CHECK(linesOf(folder / "packed/RBC.pos").size() == 4);
}

TEST_CASE("Cells are added to or removed from a given packing, or it is kept unchanged", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "20 20 20 --hematocrit 0.3 --plt_ratio 0");
  fs::rename(folder / "RBC.pos", folder / "before.pos");
  const auto before = linesOf(folder / "before.pos");
  fs::create_directory(folder / "from");
  fs::copy(folder / "before.pos", folder / "from/RBC.pos");
  const std::string box = "20 20 20 --plt_ratio 0 --start from/RBC.pos ";
  ok(folder, "20 20 20 --start from/RBC.pos");
  CHECK(linesOf(folder / "RBC.pos") == before);
  CHECK_THAT(ok(folder, box + "--hematocrit 0.42").out,
             Contains("starts from 30 of the 30 cells of from/RBC.pos"));
  CHECK(linesOf(folder / "RBC.pos").size() == 41);
  ok(folder, "check --box 20 20 20");
  // Every cell has the same chance of being drawn.
  std::map<std::string, int> drawn;
  const int runs = 40;
  for (int seed = 1; seed <= runs; ++seed) {
    ok(folder, box + "--hematocrit 0.15 --seed " + std::to_string(seed));
    const auto after = linesOf(folder / "RBC.pos");
    REQUIRE(after.size() == 15);
    REQUIRE(holdsAll(before, after));
    for (const std::string& line : after) ++drawn[line];
  }
  // Half of them each time: 20 on average, sigma 3.2.
  for (const std::string& line : before) CHECK(std::abs(drawn[line] - runs / 2) < 14);
}

TEST_CASE("Cells that all start at one position are rejected without relaxation", "[executable]") {
  const TemporaryFolder folder;
  std::string lines;
  for (int cell = 0; cell < 2000; ++cell)
    lines += std::to_string(cell % 50) + "e-6 " + std::to_string(cell / 50) + "e-6 2e-6 0 0 0\n";
  fs::create_directory(folder / "from");
  writeText(folder / "from/RBC.pos", rbcPos(lines, 2000));
  requireRefused(folder, {{"100 100 100 --rbc 2000 --start from/RBC.pos", 2,
                           "from/RBC.pos: too many of its 2000 cells coincide (at least 1999000 pairs"}});
}

TEST_CASE("Cells that start as copies of each other are separated", "[executable]") {
  const TemporaryFolder folder;
  fs::create_directory(folder / "from");
  std::string lines;
  for (int cell = 0; cell < 20; ++cell) lines += "10 13 13 0 0 0\n";
  writeText(folder / "from/RBC.pos", rbcPos(lines, 20));
  ok(folder, "26 26 26 --rbc 20 --start from/RBC.pos");
  ok(folder, "check --box 26 26 26");
}
