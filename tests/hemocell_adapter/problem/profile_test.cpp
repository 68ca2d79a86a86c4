// SPDX-License-Identifier: AGPL-3.0-or-later
// Cells distributed over the distance from the wall.
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/problem/plan_profile.h"
#include "packMesh/core/error.h"
#include "tests/hemocell_adapter/refusal.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

namespace {

nlohmann::json reportOf(const TemporaryFolder& folder) {
  return readJson(folder / "r.json");
}

/// Volume of the lumen in layers whose volume fraction of a species differs from the one asked for, weighted
/// by the difference, over the volume of the species; layers are joined until they are 2 µm thick.
double deviationOf(const nlohmann::json& wall, std::size_t species) {
  const auto& asked = wall["asked"]["species"][species]["fraction"];
  const auto& reached = wall["species"][species]["fraction"];
  const int joined = std::max(1, int(std::lround(2.0 / double(wall["width"]))));
  double off = 0.0, all = 0.0, difference = 0.0;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const double lumen = wall["lumen"][i];
    difference += lumen * (double(reached[i]) - double(asked[i]));
    all += lumen * double(reached[i]);
    if ((i + 1) % joined > 0 && i + 1 < asked.size()) continue;
    off += std::abs(difference);
    difference = 0.0;
  }
  return off / all;
}

}  // namespace

TEST_CASE("A table of concentrations is read, with blanks or commas", "[profile]") {
  TemporaryFolder folder;
  for (const char* text : {"# core\ndistance RBC PLT\n0 0 3 # wall\n\n2 0 3\n4\t1 1\n",
                           "distance,RBC,PLT\n0,0,3\n2,0,3\n4,1,1\n"}) {
    writeText(folder / "p.txt", text);
    const ProfileSource profile = readProfile(folder / "p.txt");
    CHECK_FALSE(profile.isFraction);
    CHECK(profile.at(*profile.columnOf("RBC"), 1.0) == 0.0);
    CHECK(profile.at(*profile.columnOf("RBC"), 3.0) == 0.5);
    CHECK(profile.at(*profile.columnOf("RBC"), 30.0) == 1.0);
    CHECK(profile.at(*profile.columnOf("PLT"), 3.5) == 1.5);
    CHECK(profile.columnOf("WBC") == nullptr);
  }
}

TEST_CASE("A table that cannot be read is refused with file and line", "[profile]") {
  TemporaryFolder folder;
  struct Row {
    const char *text, *message;
  };
  for (const Row& row :
       {Row{"", "expected a line such as"}, Row{"radius RBC\n", "p.txt:1: expected 'distance'"},
        Row{"distance\n0\n", "names of cells are missing"},
        Row{"distance RBC RBC\n", "a second column 'RBC'"},
        Row{"distance RBC\n0\n", "p.txt:2: expected 2 numbers, found 1"},
        Row{"distance RBC\n\n0 x\n", "p.txt:3: expected a number in [0, 1e+06], found 'x'"},
        Row{"distance RBC\n0 -1\n", "found '-1'"}, Row{"distance RBC\n0 nan\n", "found 'nan'"},
        Row{"distance RBC\n1 1\n1 2\n", "must increase"},
        Row{"fraction RBC\n0 1\n1.5 1\n", "a fraction in [0, 1]"},
        Row{"distance RBC\n0 0\n5 0\n", "no value above 0"}}) {
    CAPTURE(row.text);
    writeText(folder / "p.txt", row.text);
    CHECK_THROWS_WITH(readProfile(folder / "p.txt"), Contains(row.message));
  }
  CHECK_THROWS_WITH(readProfile(folder / "none.txt"), Contains("none.txt"));
}

TEST_CASE("A plan keeps the number of cells, and nothing is asked for in a free layer", "[profile]") {
  TemporaryFolder folder;
  writeText(folder / "p.txt", "distance RBC PLT\n0 0 3\n2 0 3\n4 1 1\n");
  const std::string file = (folder / "p.txt").string();
  for (const std::vector<std::string>& lumen : {std::vector<std::string>{"--cylinder", "x", "15", "50"},
                                                {"--sphere", "14"},
                                                {"40", "30", "30", "--walls", "z"},
                                                {"40", "30", "30", "--walls", "yz", "--ends", "periodic"}}) {
    CAPTURE(lumen);
    std::vector<std::string> words = lumen;
    words.insert(words.end(), {"--hematocrit", "0.25", "--plt_ratio", "0.3", "--profile", file});
    const Problem problem = planned(words);
    const DepthProfile& profile = *problem.layout.profile;
    CHECK(profile.species[0].freeLayer == 2.0);
    CHECK(profile.species[1].freeLayer == 0.0);
    for (std::size_t s = 0; s < 2; ++s) {
      double volume = 0.0, all = 0.0, weight = 0.0;
      for (std::size_t k = 0; k < profile.lumen.size(); ++k) {
        volume += profile.lumen[k] * profile.species[s].asked[k];
        all += profile.lumen[k];
      }
      CHECK(volume / all * problem.lumen.container->volume() ==
            Approx(double(problem.species[s].count) * problem.species[s].shape->volume()));
      for (int j = 0; j < profile.shells(); ++j) weight += profile.species[s].weight[j];
      CHECK(weight > 0.0);
      std::int64_t cells = 0;
      for (const Part& part : problem.atDemanded.parts)
        if (part.species == int(s)) {
          cells += part.cells.count;
          CHECK(part.cells.freedom.region);
          CHECK(part.cells.freedom.freeLayer.has_value() == (s == 0));
        }
      CHECK(cells == problem.species[s].count);
    }
    CHECK(profile.askedAt(profile.species[0], 1.0) == 0.0);
    CHECK(profile.askedAt(profile.species[1], 1.0) == Approx(3.0 * profile.askedAt(profile.species[1], 6.0)));
    CHECK(profile.shellAt(-1.0) == 0);
    CHECK(profile.shellAt(1e3) == profile.shells() - 1);
    for (int j = 0; j < profile.shells(); ++j)
      CHECK(profile.shellAt(0.5 * (profile.edges[j] + profile.edges[j + 1])) == j);
  }
}

TEST_CASE("What is packed has the profile that is asked for", "[executable][profile]") {
  TemporaryFolder folder;
  writeText(folder / "core.txt", "distance RBC PLT\n0 0 4\n1.5 0 4\n4 1 1\n");
  for (const char* lumen : {"--cylinder x 15 60 --ends periodic", "60 30 40 --walls z --ends periodic"})
    for (const char* seed : {"1", "2"}) {
      CAPTURE(lumen, seed);
      CHECK_THAT(ok(folder, std::string(lumen) +
                                " --hematocrit 0.3 --plt_ratio 0.4 --profile core.txt "
                                "--report r.json --seed " +
                                seed)
                     .out,
                 Contains("Profile: ") && Contains("µm from the wall: RBC 0."));
      const nlohmann::json report = reportOf(folder);
      const nlohmann::json& wall = report["measures"]["wall"];
      CHECK(report["certificate"]["clean"]);
      CHECK(report["configuration"]["profile"] == "core.txt");
      CHECK(deviationOf(wall, 0) < 0.08);
      CHECK(deviationOf(wall, 1) < 0.25);
      for (std::size_t i = 0; (i + 1.0) * double(wall["width"]) < 1.4; ++i)
        CHECK(wall["species"][0]["fraction"][i] == 0.0);
    }
  // Without a profile the deviation from it is several times as large.
  ok(folder, "--cylinder x 15 60 --hematocrit 0.3 --plt_ratio 0.4 --report r.json");
  CHECK(reportOf(folder)["measures"]["wall"]["asked"].is_null());
}

TEST_CASE("Developed flow in a case: a cell-free layer and platelets in it", "[executable][profile]") {
  SampleCase folder(
      "<packing> <hematocrit> 0.25 </hematocrit> <species name=\"RBC\"/>"
      "<species name=\"PLT\" ratio=\"0.5\"/> <profile> developed </profile> </packing>");
  CHECK_THAT(ok(folder, "config.xml --report r.json").out,
             Contains("Profile: developed flow: cell-free layer 2.04 µm"));
  const nlohmann::json wall = reportOf(folder)["measures"]["wall"];
  const auto meanUpTo = [&](std::size_t species, double depth) {
    double volume = 0.0, all = 0.0;
    for (std::size_t i = 0; i < wall["lumen"].size() && (i + 0.5) * double(wall["width"]) < depth; ++i) {
      volume += double(wall["lumen"][i]) * double(wall["species"][species]["fraction"][i]);
      all += double(wall["lumen"][i]);
    }
    return volume / all;
  };
  CHECK(meanUpTo(0, 0.9) == 0.0);
  CHECK(meanUpTo(1, 2.0) > 1.15 * meanUpTo(1, 100.0));
  CHECK_THAT(ok(folder, "check config.xml").out, Contains("Verdict: clean"));
  // Cells that are there count in their shells.
  const std::size_t cells = readPos(folder / "RBC.pos").size();
  std::filesystem::create_directory(folder / "old");
  writeText(folder / "old" / "RBC.pos", readText(folder / "RBC.pos"));
  ok(folder, "config.xml --start old/RBC.pos --seed 3");
  CHECK(readPos(folder / "RBC.pos").size() == cells);
}

TEST_CASE("A profile that makes no sense is refused", "[profile]") {
  TemporaryFolder folder;
  writeText(folder / "p.txt", "distance RBC\n0 0\n6 0\n7 1\n");
  writeText(folder / "far.txt", "distance RBC\n0 0\n60 0\n70 1\n");
  writeText(folder / "wbc.txt", "distance WBC\n0 1\n");
  requireRefused(
      folder,
      {{"30 30 30 --ends periodic --hematocrit 0.2 --profile developed", 2, "this lumen has none"},
       {"30 30 30 --hematocrit 0.2 --profile developed", 2, "this lumen has none"},
       {"--cylinder x 12 30 --hematocrit 0.3 --profile p.txt", 3, "no random packing beyond 0.62 is known"},
       {"--cylinder x 12 30 --hematocrit 0.1 --profile far.txt", 2, "'RBC' is 0 everywhere in the lumen"},
       {"--cylinder x 12 30 --hematocrit 0.1 --profile wbc.txt", 2,
        "none of the cells to pack has a profile"},
       {"--cylinder x 12 30 --wbc 3 --profile developed", 2, "that of red cells"},
       {"--cylinder x 12 30 --hematocrit 0.1 --profile none.txt", 2, "none.txt"},
       {"--cylinder x 12 30 --hematocrit 0.1 --profile developed --order columns", 2,
        "--order columns (<order>) and a profile"},
       {"--cylinder x 12 30 --hematocrit 0.1 --method cat --profile p.txt", 1, "--method relaxation"}});
  SampleCase regions(
      "<packing> <hematocrit> 0.1 </hematocrit> <profile> developed </profile>"
      "<region hematocrit=\"0.2\"> <sphere radius=\"6\" center=\"12 8 8\"/> </region> </packing>");
  CHECK_THAT(run(regions, "config.xml").err, Contains("exclude each other"));
}
