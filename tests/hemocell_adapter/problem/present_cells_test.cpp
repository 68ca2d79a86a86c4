// SPDX-License-Identifier: AGPL-3.0-or-later
// Cells that are there already, regions, axes, tiles, realisations and exports, with the real executable.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/exports.h"
#include "sample_case.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
using Catch::Matchers::Contains;
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

Ran ok(const TemporaryFolder& folder, const std::string& arguments) {
  Ran ran = run(folder.path(), arguments);
  INFO(ran.all());
  REQUIRE(ran.exitCode == 0);
  return ran;
}

}  // namespace

TEST_CASE("fixed cells stay line by line while others are added", "[executable]") {
  const SampleCase folder;
  ok(folder, "config.xml --hematocrit 0.2 --plt_ratio 0");
  const auto red = linesOf(folder.path() / "RBC.pos");
  const Ran added = ok(folder, "config.xml --fixed RBC.pos --plt 20");
  CHECK(linesOf(folder.path() / "RBC.pos") == red);
  CHECK(linesOf(folder.path() / "PLT.pos").size() == 20);
  CHECK_THAT(added.out,
             Contains("RBC: " + std::to_string(red.size()) + " of them stay where RBC.pos has them"));
  CHECK(run(folder.path(), "check config.xml").exitCode == 0);
  // A higher hematocrit around them, by the configuration.
  fs::rename(folder.path() / "RBC.pos", folder.path() / "there.pos");
  writeText(folder.path() / "config.xml",
            configXml(sampleDomain,
                      "<packing> <hematocrit> 0.24 </hematocrit> <species name=\"RBC\" "
                      "fixed=\"there.pos\"/> </packing>"));
  ok(folder, "config.xml");
  const auto more = linesOf(folder.path() / "RBC.pos");
  CHECK(more.size() >= red.size() + 3);
  CHECK(holdsAll(more, red));
  const Ran fewer = run(folder.path(), "config.xml --hematocrit 0.1");
  CHECK(fewer.exitCode == 2);
  CHECK_THAT(fewer.err, Contains("there.pos") && Contains("that are to stay, but only"));
}

TEST_CASE("fixed cells that cannot stay are refused with their number", "[executable]") {
  const SampleCase folder;
  writeText(folder.path() / "WBC.pos", "2\n12 7 7 0 0 0\n12 7.5 7 0 0 0\n");
  writeText(folder.path() / "WBC.xml", cellXml("WBC", 4.0, 600, ""));
  Ran ran = run(folder.path(), "config.xml --fixed WBC.pos --rbc 3");
  CHECK(ran.exitCode == 2);
  CHECK_THAT(ran.err, Contains("cell 1 of 'WBC, fixed' and cell 2 of 'WBC, fixed' are to stay, but meet"));
  writeText(folder.path() / "WBC.pos", "1\n12 1 7 0 0 0\n");
  ran = run(folder.path(), "config.xml --fixed WBC.pos --rbc 3");
  CHECK(ran.exitCode == 2);
  CHECK_THAT(ran.err, Contains("cell 1 of 'WBC, fixed' is to stay, but"));
  ran = run(folder.path(), "config.xml --fixed none.pos --rbc 3");
  CHECK(ran.exitCode == 2);
  CHECK_THAT(ran.err, Contains("none"));
  ran = run(folder.path(), "config.xml --fixed WBC.pos --rbc 3 --method cat");
  CHECK(ran.exitCode == 2);
  CHECK_THAT(ran.err, Contains("method cat does not know it"));
}

TEST_CASE("cells beyond those that a file announces do not count, as for HemoCell", "[executable]") {
  const TemporaryFolder folder;
  // The second one overlaps the first.
  writeText(folder.path() / "RBC.pos", "1\n8 8 8 0 0 0\n8 8 9 0 0 0\n");
  const Ran checked = run(folder.path(), "check --box 16 16 16");
  CHECK(checked.exitCode == 0);
  CHECK_THAT(checked.out, Contains("RBC: 1 cells") && Contains("Verdict: clean"));
  CHECK_THAT(checked.err, Contains("announces 1 cell, but 2 lines follow"));
  for (const char* option : {"--fixed", "--start"}) {
    const Ran packed =
        run(folder.path(), std::string("16 16 16 --rbc 4 --output-dir packed ") + option + " RBC.pos");
    INFO(packed.all());
    CHECK(packed.exitCode == 0);
    CHECK_THAT(packed.err, Contains("announces 1 cell, but 2 lines follow"));
  }
  CHECK(linesOf(folder.path() / "packed/RBC.pos").size() == 4);
}

TEST_CASE("a packing is topped up, thinned out and left alone", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "20 20 20 --hematocrit 0.3 --plt_ratio 0");
  fs::rename(folder.path() / "RBC.pos", folder.path() / "before.pos");
  const auto before = linesOf(folder.path() / "before.pos");
  fs::create_directory(folder.path() / "from");
  fs::copy(folder.path() / "before.pos", folder.path() / "from/RBC.pos");
  const std::string box = "20 20 20 --plt_ratio 0 --start from/RBC.pos ";
  ok(folder, "20 20 20 --start from/RBC.pos");
  CHECK(linesOf(folder.path() / "RBC.pos") == before);
  const Ran topped = ok(folder, box + "--hematocrit 0.42");
  CHECK_THAT(topped.out, Contains("begins with 30 of the 30 cells of from/RBC.pos"));
  CHECK(linesOf(folder.path() / "RBC.pos").size() == 41);
  CHECK(run(folder.path(), "check --box 20 20 20").exitCode == 0);
  // Every cell has the same chance of being drawn.
  std::map<std::string, int> drawn;
  const int runs = 40;
  for (int seed = 1; seed <= runs; ++seed) {
    ok(folder, box + "--hematocrit 0.15 --seed " + std::to_string(seed));
    const auto after = linesOf(folder.path() / "RBC.pos");
    REQUIRE(after.size() == 15);
    REQUIRE(holdsAll(before, after));
    for (const std::string& line : after) ++drawn[line];
  }
  // Half of them each time: 20 on average, sigma 3.2.
  for (const std::string& line : before) CHECK(std::abs(drawn[line] - runs / 2) < 14);
}

TEST_CASE("regions have their own hematocrit, axes their direction, walls their layer", "[executable]") {
  SampleCase folder(
      "<packing> <hematocrit> 0.05 </hematocrit> <species name=\"RBC\" axis=\"1 0 0\" spread=\"30\"/>"
      "<species name=\"PLT\" ratio=\"0.2\"/> <cellFreeLayer> 1.5 </cellFreeLayer>"
      "<region hematocrit=\"0.2\"> <sphere radius=\"6\" center=\"12 8 8\"/> </region>"
      "<region hematocrit=\"0\"> <box origin=\"-1 -1 -1\" size=\"6 20 20\"/> </region> </packing>");
  const Ran ran = ok(folder, "config.xml --export csv");
  CHECK_THAT(ran.out, Contains("Hematocrit of region 2: 0.0000, 0 red cells"));
  CHECK_THAT(ran.out, Contains("RBC: thin axis within 30 degrees of (1, 0, 0)"));
  int inBall = 0, all = 0;
  for (const PosLine& line : readPos(folder.path() / "RBC.pos")) {
    const Vec3 axis = placementOf(line).linear.col(1);
    CHECK(std::abs(axis.x()) >= std::cos(30.001 * std::acos(-1.0) / 180.0));
    const bool inside = (line.position - Vec3(12, 8, 8)).norm() <= 6.0;
    inBall += inside;
    ++all;
    CHECK((inside || line.position.x() > 5.0));
  }
  CHECK(inBall == std::lround(0.2 * 4.0 / 3.0 * std::acos(-1.0) * 216.0 / 81.1163));
  CHECK(all > inBall);
  const auto minimumOf = [&](const char* name) {
    double nearest = 1e9;
    for (const PosLine& line : readPos(folder.path() / name))
      nearest =
          std::min(nearest, 7.5 - Eigen::Vector2d(line.position.y() - 8.0, line.position.z() - 8.0).norm());
    return nearest;
  };
  CHECK(minimumOf("RBC.pos") > 1.5 + 1.1);
  CHECK(readText(folder.path() / "cells.csv").rfind("id,species,x,y,z,qw,qx,qy,qz\n1,RBC,", 0) == 0);
}

TEST_CASE("the hematocrit of a region is that of all its red cells", "[executable]") {
  for (const char* number : {"ratio=\"0.4\"", "count=\"3\""}) {
    CAPTURE(number);
    SampleCase folder(
        "<packing> <hematocrit> 0.05 </hematocrit> <species name=\"RBC\"/>"
        "<species name=\"RBC_stiff\" " +
        std::string(number) +
        "/> <region hematocrit=\"0.2\"> <box origin=\"4 0 0\" size=\"16 16 16\"/> </region>"
        "</packing>");
    writeText(folder.path() / "RBC_stiff.xml", cellXml("RBC_stiff", 3.91, 600, ""));
    const Ran ran = ok(folder, "config.xml");
    // 0.2 of 16 µm of the tube are 7.0 red cells, 0.05 of the rest another one.
    CHECK_THAT(ran.out, Contains("Hematocrit of region 1: 0.2") && Contains(", 7 red cells with their"));
    int inside = 0, all = 0;
    for (const char* name : {"RBC.pos", "RBC_stiff.pos"})
      for (const PosLine& line : readPos(folder.path() / name)) {
        ++all;
        inside += line.position.x() >= 4.0 && line.position.x() <= 20.0;
      }
    CHECK(inside == 7);
    CHECK(all == 8);
    CHECK(readPos(folder.path() / "RBC_stiff.pos").size() == 3);
  }
}

TEST_CASE("a region too small for its hematocrit is refused, or told", "[executable]") {
  SampleCase folder;
  const auto packed = [&](const char* rest, const char* region, const char* radius) {
    writeText(folder.path() / "config.xml",
              configXml(sampleDomain, std::string("<packing><species name=\"RBC\"/><hematocrit>") + rest +
                                          "</hematocrit><region hematocrit=\"" + region +
                                          "\"><sphere center=\"12 8 8\" radius=\"" + radius +
                                          "\"/></region></packing>"));
    return run(folder.path(), "config.xml --dry-run");
  };
  const Ran refused = packed("0.2", "0.45", "1.5");
  CHECK(refused.exitCode == 2);
  CHECK_THAT(refused.err, Contains("<sphere>") && Contains("too little for a red cell"));
  const Ran whole = packed("0.2", "0.45", "4");  // 1.49 cells
  CHECK(whole.exitCode == 0);
  CHECK_THAT(whole.err, Contains("region 1 is so small that whole cells cannot meet its hematocrit: 0.302") &&
                            Contains("with 1 red cell, 0.45 asked for"));
  CHECK_THAT(packed("0.001", "0.1", "8").err, Contains("outside the regions there will be no red cell"));
  CHECK(packed("0.2", "0.12", "7").err.empty());
}

TEST_CASE("constraints that make no sense are refused", "[executable]") {
  const SampleCase folder;
  const auto refused = [&](const std::string& packing, const std::string& arguments = "") {
    writeText(folder.path() / "config.xml", configXml(sampleDomain, "<packing>" + packing + "</packing>"));
    const Ran ran = run(folder.path(), "config.xml " + arguments);
    CHECK((ran.exitCode == 1 || ran.exitCode == 2));
    CHECK(!fs::exists(folder.path() / "RBC.pos"));
    return ran.err;
  };
  const std::string ball = "<sphere radius=\"3\" center=\"12 8 8\"/>";
  CHECK_THAT(refused("<hematocrit>0.1</hematocrit><region> " + ball + "</region>"),
             Contains("attribute hematocrit is missing"));
  CHECK_THAT(refused("<hematocrit>0.1</hematocrit><region hematocrit=\"0.2\"/>"),
             Contains("expected one body"));
  CHECK_THAT(refused("<hematocrit>0.1</hematocrit><region hematocrit=\"1\">" + ball + "</region>"),
             Contains("[0, 1)"));
  CHECK_THAT(refused("<region hematocrit=\"0.2\">" + ball + "</region>", "--rbc 3"),
             Contains("needs a hematocrit of the rest"));
  CHECK_THAT(refused("<hematocrit>0.1</hematocrit><region hematocrit=\"0.2\"><sphere radius=\"3\" "
                     "center=\"99 8 8\"/></region>"),
             Contains("outside the lumen"));
  CHECK_THAT(
      refused("<hematocrit>0.1</hematocrit><region hematocrit=\"0.2\">" + ball + "</region>", "--method cat"),
      Contains("method cat does not know it"));
  CHECK_THAT(refused("<species name=\"RBC\" count=\"3\" axis=\"0 0 0\"/>"), Contains("is no direction"));
  CHECK_THAT(refused("<species name=\"RBC\" count=\"3\" spread=\"3\"/>"), Contains("no axis"));
  CHECK_THAT(refused("<species name=\"RBC\" count=\"3\" axis=\"0 0 1\" spread=\"91\"/>"),
             Contains("[0, 90]"));
  CHECK_THAT(refused("<species name=\"RBC\" count=\"3\"/><export>vrml</export>"),
             Contains("csv, lammps or mirheo"));
  CHECK_THAT(refused("<species name=\"RBC\" count=\"3\"/>", "--tile 2 1 1"),
             Contains("is for periodic boxes"));
}

TEST_CASE("options of constraints are checked", "[executable]") {
  const TemporaryFolder folder;
  writeText(folder.path() / "RBC.pos", "1\n5 5 5 0 0\n");
  struct Row {
    const char* options;
    int exitCode;
    const char* message;
  };
  for (const Row& row :
       {Row{"--cell-free-layer -1", 1, "'--cell-free-layer': expected a number in [0, 100]"},
        Row{"--cell-free-layer 10", 2, "larger than the lumen"},
        Row{"--orient RBC 0 0 0 10", 2, "is no direction"},
        Row{"--orient RBC 0 0 1", 1, "the angle is missing"},
        Row{"--orient RBC 0 0 1 100", 1, "[0, 90]"},
        Row{"--orient WBC 0 0 1 10", 1, "no such cells to pack"},
        Row{"--start RBC.pos", 2, "RBC.pos:2"},
        Row{"--start none.pos", 2, "none.pos"},
        Row{"--export vtk", 1, "csv, lammps or mirheo"},
        Row{"--stock RBC -1", 1, "expected a whole number"},
        Row{"--realisations 2 --restart x.h5", 1, "go on from the state of one of them"},
        Row{"--realisations 2 --seed 9223372036854775807", 1, "larger than a seed may be"},
        Row{"--start RBC.pos --fixed ./RBC.pos", 2, "cannot both stay (fixed) and move (start)"},
        Row{"--orient RBC 0 0 1 20 --noRotate", 2, "keeps every orientation at 0 0 0"},
        Row{"--walls none --cell-free-layer 1", 2, "this lumen has none"},
        Row{"--walls none --ends periodic --tile 2 1 1 --method cat", 1, "not for --method cat"},
        Row{"--order columns", 2, "periodic along all axes"},
        Row{"--order rows", 1, "random or columns"},
        Row{"--order columns --walls none --method cat", 1, "not for --method cat"},
        Row{"--order columns --walls none --ends periodic --noRotate", 2, "no cell is to be turned"},
        Row{"--pre-inlet Xpos", 2, "lengthN"},
        Row{"--tile 2 2", 1, "the nz is missing"}}) {
    CAPTURE(row.options);
    const std::string options = row.options;
    const bool ownWalls = options.find("--walls") != options.npos;
    const Ran ran =
        run(folder.path(), "16 16 16 --rbc 2 " + std::string(ownWalls ? "" : "--walls xyz ") + options);
    INFO(ran.all());
    CHECK(ran.exitCode == row.exitCode);
    CHECK_THAT(ran.err, Contains(row.message));
  }
}

TEST_CASE("cells in columns are denser than at random", "[executable]") {
  const TemporaryFolder folder;
  const Ran ran =
      ok(folder,
         "40 40 40 --hematocrit 0.63 --ends periodic --plt_ratio 0 --order columns --report report.json");
  CHECK_THAT(ran.out, Contains("in columns"));
  CHECK(run(folder.path(), "check --box 40 40 40 --ends periodic").exitCode == 0);
  const auto report = nlohmann::json::parse(readText(folder.path() / "report.json"));
  CHECK(report["configuration"]["order"] == "columns");
  CHECK(report["measures"]["orientation"][0]["nematic"] > 0.99);
  CHECK_THAT(ok(folder, "40 40 40 --hematocrit 0.63 --ends periodic --order columns --dry-run").out,
             Contains("In columns"));
}

TEST_CASE("a box is repeated at the same hematocrit", "[executable]") {
  const TemporaryFolder folder;
  const Ran ran = ok(folder,
                     "16 18 20 --ends periodic --hematocrit 0.3 --plt_ratio 0.1 --tile 2 1 3 --export csv "
                     "--report report.json");
  const int cells = 6 * 21;  // 0.3 · 16 · 18 · 20 / 81.1163 = 21.3
  CHECK(readPos(folder.path() / "RBC.pos").size() == cells);
  CHECK(run(folder.path(), "check --box 32 18 60 --ends periodic").exitCode == 0);
  CHECK_THAT(ran.out, Contains("periodic box 32 x 18 x 60"));
  // Images of one cell follow each other.
  const auto lines = readPos(folder.path() / "RBC.pos");
  CHECK(lines[1].position == lines[0].position + Vec3(0, 0, 20));
  CHECK(lines[1].angles == lines[0].angles);
  const auto report = nlohmann::json::parse(readText(folder.path() / "report.json"));
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
  CHECK(run(folder.path(), "16 18 20 --ends periodic --rbc 3 --walls x --tile 2 1 1").exitCode == 2);
  CHECK(run(folder.path(), "16 18 20 --ends periodic --rbc 3 --walls x --tile 1 2 1").exitCode == 0);
  CHECK(run(folder.path(), "16 18 20 --ends periodic --rbc 3 --tile 0 2 1").exitCode == 1);
  CHECK(run(folder.path(), "16 18 20 --ends periodic --rbc 3 --tile 10000 10000 1").exitCode == 2);
}

TEST_CASE("realisations differ by their seeds, each in its folder", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "15 15 15 --hematocrit 0.2 --plt_ratio 0 --seed 7 --output-dir alone");
  ok(folder, "15 15 15 --hematocrit 0.2 --plt_ratio 0 --seed 6 --realisations 10");
  std::set<std::string> texts;
  for (const char* i : {"01", "02", "03", "04", "05", "06", "07", "08", "09", "10"})
    texts.insert(readText(folder.path() / (std::string("realisation_") + i) / "RBC.pos"));
  CHECK(texts.size() == 10);
  CHECK(readText(folder.path() / "realisation_02/RBC.pos") == readText(folder.path() / "alone/RBC.pos"));
  const Ran failed = run(folder.path(), "15 15 15 --hematocrit 0.7 --max-iterations 5 --realisations 2");
  CHECK(failed.exitCode == 3);
  CHECK_THAT(failed.err, Contains("realisations that failed: 1, 2"));
  CHECK(run(folder.path(), "15 15 15 --rbc 2 --realisations 0").exitCode == 1);
}

TEST_CASE("a realisation goes on with the files of its own folder", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "15 15 15 --rbc 3 --realisations 2 --state s.h5 --report r.json");
  const fs::path one = folder.path() / "realisation_2";
  const std::string before = readText(one / "RBC.pos");
  fs::remove(one / "RBC.pos");
  fs::remove(one / "r.json");
  ok(folder, "--restart realisation_2/s.h5");
  CHECK(readText(one / "RBC.pos") == before);
  CHECK(fs::exists(one / "r.json"));
  CHECK_FALSE(fs::exists(folder.path() / "r.json"));
  CHECK_FALSE(fs::exists(folder.path() / "s.h5"));
}

TEST_CASE("a restart goes on with the realisations that are left, from wherever it is started",
          "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "15 15 15 --rbc 3 --realisations 3 --state s.h5");
  std::map<std::string, std::string> before;
  for (const char* i : {"1", "2", "3"})
    before[i] = readText(folder.path() / (std::string("realisation_") + i) / "RBC.pos");
  for (const bool inside : {false, true}) {
    CAPTURE(inside);
    for (const char* i : {"2", "3"})
      fs::remove(folder.path() / (std::string("realisation_") + i) / "RBC.pos");
    const Ran ran = inside ? run(folder.path() / "realisation_2", "--restart s.h5")
                           : run(folder.path(), "--restart realisation_2/s.h5");
    INFO(ran.all());
    CHECK(ran.exitCode == 0);
    CHECK_THAT(ran.out, !Contains("Realisation 1 of 3") && Contains("Realisation 2 of 3: seed 2") &&
                            Contains("Realisation 3 of 3: seed 3") && Contains("Of 3 realisations:") &&
                            Contains("Realisations: 3 of 3 written"));
    for (const auto& [i, text] : before)
      CHECK(readText(folder.path() / ("realisation_" + i) / "RBC.pos") == text);
    CHECK_FALSE(fs::exists(folder.path() / "realisation_2/realisation_2"));
    CHECK_FALSE(fs::exists(folder.path() / "realisation_2/realisation_1"));
  }
  const std::string table = readText(folder.path() / "realisations.csv");
  CHECK(std::count(table.begin(), table.end(), '\n') == 4);
  fs::rename(folder.path() / "realisation_2/s.h5", folder.path() / "s.h5");
  const Ran elsewhere = run(folder.path(), "--restart s.h5");
  CHECK(elsewhere.exitCode == 1);
  CHECK_THAT(elsewhere.err, Contains("./realisation_1/state.h5; found 's.h5'"));
}

TEST_CASE("realisations of a case go on inside the folder of one, and check sees them all", "[executable]") {
  const SampleCase folder(
      "<packing> <species name=\"RBC\" count=\"3\"/> <realisations> 2 </realisations> </packing>");
  ok(folder, "config.xml --state s.h5");
  const std::string before = readText(folder.path() / "realisation_2/RBC.pos");
  fs::remove_all(folder.path() / "realisation_2");
  const Ran goesOn = run(folder.path() / "realisation_1", "--restart s.h5");
  INFO(goesOn.all());
  CHECK(goesOn.exitCode == 0);
  CHECK(readText(folder.path() / "realisation_2/RBC.pos") == before);
  const Ran elsewhere =
      run(folder.path().parent_path(), "--restart '" + (folder.path() / "realisation_1/s.h5").string() + "'");
  CHECK(elsewhere.exitCode == 0);

  Ran checked = ok(folder, "check config.xml");
  CHECK_THAT(checked.out, Contains("realisation_1: clean; 3 cells") &&
                              Contains("realisation_2: clean; 3 cells") &&
                              Contains("HemoCell keeps 3 of 3") && Contains("Verdict: 2 of 2 folders clean"));
  // A cell twice, and files beside the realisations.
  writeText(folder.path() / "realisation_2/RBC.pos", "2\n12 8 8 0 0 0\n12 8 8 0 0 0\n");
  writeText(folder.path() / "RBC.pos", before);
  checked = run(folder.path(), "check config.xml");
  CHECK(checked.exitCode == 4);
  CHECK_THAT(checked.out, Contains("realisation_1: clean") &&
                              Contains("realisation_2: NOT clean; 2 cells, hematocrit") &&
                              Contains("1 overlapping pairs") && Contains("HemoCell keeps 3 of 3 RBC") &&
                              Contains("Verdict: 2 of 3 folders clean"));
  CHECK(ok(folder, "check config.xml --output-dir realisation_1").out.find("Verdict: clean") !=
        std::string::npos);
  writeText(folder.path() / "realisation_1/RBC.pos", "none\n");
  checked = run(folder.path(), "check config.xml");
  CHECK(checked.exitCode == 4);
  CHECK_THAT(checked.out, Contains("realisation_1: not examined") && Contains("1 of 3 folders clean"));
  CHECK_THAT(checked.err, Contains("realisation_1/RBC.pos:1"));
  CHECK_THAT(ok(folder, "config.xml").err, Contains("RBC.pos belongs to none of the realisations"));
}

TEST_CASE("means and spreads of realisations are told and written", "[executable]") {
  const TemporaryFolder folder;
  const Ran ran = ok(folder, "18 18 18 --hematocrit 0.4 --plt_ratio 0 --realisations 3 --seed 5");
  CHECK_THAT(ran.out, Contains("Of 3 realisations:") && Contains("std. dev.") &&
                          Contains("  hematocrit of the lumen") && Contains("  minimum gap [µm]") &&
                          Contains("  minimum gap to the wall [µm]") && Contains("  sweeps") &&
                          Contains("  CPU time [s]"));
  std::istringstream rows(readText(folder.path() / "realisations.csv"));
  std::string row;
  std::getline(rows, row);
  CHECK(row ==
        "realisation,seed,outcome,cells,hematocrit,minimum_gap_um,minimum_wall_gap_um,sweeps,cpu_s,wall_s");
  for (int i = 1; i <= 3; ++i) {
    REQUIRE(std::getline(rows, row));
    CAPTURE(row);
    CHECK(row.rfind(std::to_string(i) + "," + std::to_string(4 + i) + ",certified,", 0) == 0);
    // The time of one realisation is its own: one thread cannot take more of it than has passed.
    double cpu = 0.0, wall = 0.0;
    const std::size_t last = row.rfind(','), before = row.rfind(',', last - 1);
    std::istringstream(row.substr(before + 1, last - before - 1)) >> cpu;
    std::istringstream(row.substr(last + 1)) >> wall;
    CHECK(cpu <= wall + 0.02);
  }
  CHECK_FALSE(std::getline(rows, row));
  ok(folder, "15 15 15 --hematocrit 0.7 --max-iterations 1 --realisations 2 --best-effort");
  CHECK_THAT(readText(folder.path() / "realisations.csv"), Contains("1,1,bestEffort,"));
  CHECK(run(folder.path(), "15 15 15 --hematocrit 0.7 --max-iterations 1 --realisations 2").exitCode == 3);
  CHECK_THAT(readText(folder.path() / "realisations.csv"), Contains("2,2,failed,,,,,,,"));
}

TEST_CASE("a dry run tells of realisations and repetition, and no time where there is no end",
          "[executable]") {
  const TemporaryFolder folder;
  const Ran ran = ok(folder, "16 16 16 --ends periodic --rbc 5 --tile 2 3 4 --realisations 7 --dry-run");
  CHECK_THAT(ran.out, Contains("2 x 3 x 4 times: 120 cells"));
  CHECK_THAT(ran.out, Contains("7 realisations"));
  CHECK_THAT(ok(folder, "16 16 16 --hematocrit 0.7 --dry-run").out, Contains("Time: cannot be told"));
}

TEST_CASE("options of packing are refused by check", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "16 16 16 --rbc 2");
  for (const char* option : {"--dry-run", "--validate", "--pov", "--export csv", "--realisations 2",
                             "--tile 1 2 1", "--report r.json", "--vtp", "--vtp-meshes", "--state s.h5",
                             "--restart s.h5", "--checkpoint-every 3"}) {
    CAPTURE(option);
    const Ran ran = run(folder.path(), std::string("check --box 16 16 16 ") + option);
    CHECK(ran.exitCode == 1);
    CHECK_THAT(ran.err, Contains("is for packing, not for check"));
  }
}

TEST_CASE("exports hold the cells of the .pos files", "[executable]") {
  const TemporaryFolder folder;
  // A format that is asked for twice is written once.
  ok(folder,
     "16 16 16 --ends periodic --rbc 5 --plt 3 --export csv --export csv --export lammps --export mirheo");
  const auto red = readPos(folder.path() / "RBC.pos"), platelets = readPos(folder.path() / "PLT.pos");
  std::istringstream rows(readText(folder.path() / "cells.csv"));
  std::string row;
  std::getline(rows, row);
  std::size_t n = 0;
  while (std::getline(rows, row)) {
    std::replace(row.begin(), row.end(), ',', ' ');
    std::istringstream in(row);
    std::size_t id = 0;
    std::string species;
    double x, y, z, w, a, b, c;
    in >> id >> species >> x >> y >> z >> w >> a >> b >> c;
    REQUIRE(in);
    CHECK(id == ++n);
    const PosLine& line = n <= red.size() ? red[n - 1] : platelets[n - 1 - red.size()];
    CHECK(species == (n <= red.size() ? "RBC" : "PLT"));
    CHECK(Vec3(x, y, z) == line.position);
    CHECK((Quaternion(w, a, b, c).toRotationMatrix() - placementOf(line).linear).cwiseAbs().maxCoeff() <
          1e-12);
  }
  CHECK(n == 8);
  std::istringstream numbers(readText(folder.path() / "RBC.com_q.txt"));
  std::vector<double> all{std::istream_iterator<double>(numbers), {}};
  REQUIRE(all.size() == 7 * red.size());
  CHECK(all[7] == red[1].position.x());
  const std::string data = readText(folder.path() / "cells.lammps");
  CHECK_THAT(data, Contains("8 atoms\n8 ellipsoids\n2 atom types\n") && Contains("0 16 xlo xhi") &&
                       Contains("Atoms # ellipsoid\n\n1 1 1 1 ") && Contains("\nEllipsoids\n\n1 7.8"));
}
