// SPDX-License-Identifier: AGPL-3.0-or-later
// Regions with a hematocrit of their own, axes and layers, with the real executable.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "hemocell_adapter/hemocell/pos_file.h"
#include "tests/hemocell_adapter/refusal.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
namespace fs = std::filesystem;

TEST_CASE("Regions have their own hematocrit, axes their direction, walls their layer", "[executable]") {
  SampleCase folder(
      "<packing> <hematocrit> 0.05 </hematocrit> <species name=\"RBC\" axis=\"1 0 0\" spread=\"30\"/>"
      "<species name=\"PLT\" ratio=\"0.2\"/> <cellFreeLayer> 1.5 </cellFreeLayer>"
      "<region hematocrit=\"0.2\"> <sphere radius=\"6\" center=\"12 8 8\"/> </region>"
      "<region hematocrit=\"0\"> <box origin=\"-1 -1 -1\" size=\"6 20 20\"/> </region> </packing>");
  const Ran ran = ok(folder, "config.xml --export csv");
  CHECK_THAT(ran.out, Contains("Hematocrit of region 2: 0.0000, 0 red cells"));
  CHECK_THAT(ran.out, Contains("RBC: symmetry axis within 30 degrees of (1, 0, 0)"));
  int inBall = 0, all = 0;
  for (const PosLine& line : readPos(folder / "RBC.pos")) {
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
    for (const PosLine& line : readPos(folder / name))
      nearest = std::min(nearest, 7.5 - Vec2(line.position.y() - 8.0, line.position.z() - 8.0).norm());
    return nearest;
  };
  CHECK(minimumOf("RBC.pos") > 1.5 + 1.1);
  CHECK_THAT(readText(folder / "cells.csv"), Contains("\nid,species,x,y,z,qw,qx,qy,qz\n1,RBC,"));
}

TEST_CASE("The hematocrit of a region is that of all its red cells", "[executable]") {
  for (const char* number : {"ratio=\"0.4\"", "count=\"3\""}) {
    CAPTURE(number);
    SampleCase folder(
        "<packing> <hematocrit> 0.05 </hematocrit> <species name=\"RBC\"/>"
        "<species name=\"RBC_stiff\" " +
        std::string(number) +
        "/> <region hematocrit=\"0.2\"> <box origin=\"4 0 0\" size=\"16 16 16\"/> </region>"
        "</packing>");
    writeText(folder / "RBC_stiff.xml", cellXml("RBC_stiff", 3.91, 600, ""));
    const Ran ran = ok(folder, "config.xml");
    // 0.2 of 16 µm of the tube are 7.0 red cells, 0.05 of the rest another one.
    CHECK_THAT(ran.out, Contains("Hematocrit of region 1: 0.2") && Contains(", 7 red cells with their"));
    int inside = 0, all = 0;
    for (const char* name : {"RBC.pos", "RBC_stiff.pos"})
      for (const PosLine& line : readPos(folder / name)) {
        ++all;
        inside += line.position.x() >= 4.0 && line.position.x() <= 20.0;
      }
    CHECK(inside == 7);
    CHECK(all == 8);
    CHECK(readPos(folder / "RBC_stiff.pos").size() == 3);
  }
}

TEST_CASE("A region too small for its hematocrit is rejected or gives a warning", "[executable]") {
  SampleCase folder;
  const auto packed = [&](const char* rest, const char* region, const char* radius) {
    writeText(folder / "config.xml",
              configXml(sampleDomain, std::string("<packing><species name=\"RBC\"/><hematocrit>") + rest +
                                          "</hematocrit><region hematocrit=\"" + region +
                                          "\"><sphere center=\"12 8 8\" radius=\"" + radius +
                                          "\"/></region></packing>"));
    return run(folder, "config.xml --dry-run");
  };
  CHECK_THAT(withExit(2, packed("0.2", "0.45", "1.5")).err,
             Contains("<sphere>") && Contains("too little for a red cell"));
  const Ran whole = packed("0.2", "0.45", "4");  // 1.49 cells
  CHECK(whole.exitCode == 0);
  CHECK_THAT(whole.err, Contains("region 1 is so small that whole cells cannot meet its hematocrit: 0.302") &&
                            Contains("with 1 red cell, 0.45 requested"));
  CHECK_THAT(packed("0.001", "0.1", "8").err, Contains("outside the regions there will be no red cell"));
  CHECK(packed("0.2", "0.12", "7").err.empty());
}

TEST_CASE("With a hematocrit of 0, cells are in regions alone", "[executable]") {
  SampleCase folder;
  writeText(folder / "config.xml",
            configXml(sampleDomain,
                      "<packing><species name=\"RBC\"/><hematocrit>0</hematocrit><region "
                      "hematocrit=\"0.2\"><sphere center=\"6 8 8\" radius=\"6\"/></region></packing>"));
  CHECK_THAT(ok(folder, "config.xml").err, !Contains("outside the regions"));
  const std::vector<PosLine> lines = readPos(folder / "RBC.pos");
  CHECK(lines.size() >= 1);
  for (const PosLine& line : lines) CHECK(line.position.x() < 12.1);
}

namespace {

/// Two branches from x = 15 on, y < 9 and y > 11, and these regions.
std::string bifurcation(const std::string& packing) {
  return "'<packing><container><box size=\"40 20 10\"/><obstacles><box origin=\"15 9 -1\" size=\"26 2 12\"/>"
         "</obstacles></container>" +
         packing + "</packing>' ";
}

/// Cells of a file, and of them those in the upper branch beyond x = 18.
std::pair<int, int> inUpperBranch(const fs::path& file) {
  int all = 0, beyond = 0;
  for (const PosLine& line : readPos(file)) {
    ++all;
    beyond += line.position.y() > 10.0 && line.position.x() >= 18.0;
  }
  return {all, beyond};
}

const std::string upperBranch = "<beyond point=\"18 15 5\" direction=\"1 0 0\"/>";

}  // namespace

TEST_CASE("A branch holds as many red cells as are requested, whatever the seed", "[executable][long]") {
  const TemporaryFolder folder;
  using Counts = std::pair<int, int>;
  for (const std::string seed : {"1", "2", "3", "4"}) {
    CAPTURE(seed);
    // Alone, with others elsewhere, and out of a total.
    const std::string region = "<region count=\"5\">" + upperBranch + "</region>";
    Ran ran = ok(folder, bifurcation(region) + "--plt_ratio 0 --seed " + seed);
    CHECK_THAT(ran.out,
               Contains("Red cells of region 1: 5 (") && Contains(", 5 red cells with their centres"));
    CHECK(inUpperBranch(folder / "RBC.pos") == Counts(5, 5));
    ok(folder,
       bifurcation("<hematocrit>0.1</hematocrit><species name=\"RBC\"/>" + region) + "--seed " + seed);
    const Counts dense = inUpperBranch(folder / "RBC.pos");
    CHECK(dense.second == 5);
    CHECK(dense.first == 5 + std::lround(0.1 * (7500.0 - 1980.0) / 81.1163));
    ok(folder, bifurcation("<species name=\"RBC\" count=\"9\"/>" + region) + "--seed " + seed);
    CHECK(inUpperBranch(folder / "RBC.pos") == Counts(9, 5));
  }
}

TEST_CASE("A branch is named by a half-space, too", "[executable]") {
  const TemporaryFolder folder;
  ok(folder,
     bifurcation("<species name=\"RBC\"/><region count=\"6\"><halfSpace point=\"9 11 3\" normal=\"0 2 "
                 "0\"/></region>"));
  const std::vector<PosLine> lines = readPos(folder / "RBC.pos");
  CHECK(lines.size() == 6);
  for (const PosLine& line : lines) CHECK(line.position.y() >= 11.0);
}

TEST_CASE("The number of red cells of a region is that of all their kinds", "[executable][long]") {
  SampleCase folder;
  writeText(folder / "RBC_stiff.xml", cellXml("RBC_stiff", 3.91, 600, ""));
  const std::string half = "<halfSpace point=\"12 8 8\" normal=\"1 0 0\"/>";
  const auto packed = [&](const std::string& packing) {
    writeText(folder / "config.xml", configXml(sampleDomain, "<packing>" + packing + "</packing>"));
    ok(folder, "config.xml");
    std::array<int, 2> beyond = {0, 0}, all = {0, 0};
    const char* const names[] = {"RBC.pos", "RBC_stiff.pos"};
    for (int s : {0, 1}) {
      if (!fs::exists(folder / names[s])) continue;  // there are none
      for (const PosLine& line : readPos(folder / names[s])) {
        ++all[s];
        beyond[s] += line.position.x() >= 12.0;
      }
    }
    return std::pair(all, beyond);
  };
  const std::string rest = "<hematocrit>0.1</hematocrit><species name=\"RBC\"/>";
  for (const char* stiff : {"count=\"4\"", "ratio=\"0.4\""}) {
    CAPTURE(stiff);
    const auto [all, beyond] =
        packed(rest + "<species name=\"RBC_stiff\" " + stiff + "/><region count=\"7\">" + half + "</region>");
    CHECK(beyond[0] + beyond[1] == 7);
    CHECK(all[0] + all[1] > 7);
    CHECK(all[1] == 4);
  }
  // Red cells of the region are among them; in one without a number of its own they come on top.
  const std::string own = "<species name=\"RBC_stiff\" count=\"3\"/>";
  const auto [all, beyond] = packed(rest + "<region count=\"7\">" + half + own + "</region>");
  CHECK(beyond == std::array<int, 2>{4, 3});
  CHECK(all[1] == 3);
  const auto plain = packed(rest + "<species name=\"RBC_stiff\" count=\"0\"/>").first;
  CHECK(packed(rest + "<region>" + half + own + "</region>").first == std::array<int, 2>{plain[0], 3});
}

TEST_CASE("Regions have cells of their own, beside those of the lumen", "[executable]") {
  SampleCase folder;
  writeText(
      folder / "config.xml",
      configXml(
          sampleDomain,
          "<packing><hematocrit>0.1</hematocrit><species name=\"RBC\"/><region><beyond point=\"16 8 8\" "
          "direction=\"1 0 0\"/><species name=\"PLT\" count=\"20\"/></region></packing>"));
  for (const std::string seed : {"1", "2", "3"}) {
    CHECK_THAT(ok(folder, "config.xml --seed " + seed).out, Contains("region 1, 20 PLT of its own (") &&
                                                                Contains("Cells of region 1 alone: 20 PLT") &&
                                                                Contains("PLT: 20 (in regions)"));
    const std::vector<PosLine> platelets = readPos(folder / "PLT.pos");
    CHECK(platelets.size() == 20);
    for (const PosLine& line : platelets) CHECK(line.position.x() >= 16.0);
    bool before = false, beyond = false;  // red cells are anywhere
    for (const PosLine& line : readPos(folder / "RBC.pos"))
      (line.position.x() < 16.0 ? before : beyond) = true;
    CHECK((before && beyond));
  }
  CHECK_THAT(ok(folder, "config.xml --plt 6").out, Contains("PLT: 26 (6 requested, 20 in regions)"));
  int beyond = 0;
  for (const PosLine& line : readPos(folder / "PLT.pos")) beyond += line.position.x() >= 16.0;
  CHECK(beyond >= 20);
  CHECK(readPos(folder / "PLT.pos").size() == 26);
}

TEST_CASE("Invalid regions are refused with their place", "[regions]") {
  const SampleCase folder;
  const auto messageOf = [&](const std::string& region,
                             const std::string& cells = "<species name=\"RBC\"/>") {
    writeText(folder / "config.xml",
              configXml(sampleDomain, "<packing>\n" + cells + "\n" + region + "</packing>"));
    const Ran refusal = ended(folder, 2, "config.xml");
    return refusal.err;
  };
  const std::string ball = "<sphere radius=\"6\" center=\"12 8 8\"/>";
  CHECK_THAT(messageOf("<region count=\"3\" hematocrit=\"0.1\">" + ball + "</region>"),
             Contains("config.xml:8: <region>: has both a hematocrit and a count"));
  CHECK_THAT(messageOf("<region count=\"-3\">" + ball + "</region>"),
             Contains("config.xml:8: <region>, attribute count: expected a whole number"));
  CHECK_THAT(messageOf("<region>" + ball + "</region>"),
             Contains("a count of red cells, or species of its own"));
  CHECK_THAT(
      messageOf("<region count=\"2\">" + ball + ball + "</region>"),
      Contains("expected one body inside: <box>, <cylinder>, <sphere>, <mesh>, <halfSpace> or <beyond>"));
  CHECK_THAT(messageOf("<region count=\"2\"><halfspace/></region>"), Contains("did you mean 'halfSpace'?"));
  CHECK_THAT(messageOf("<region count=\"2\"><halfSpace point=\"1 2 3\"/></region>"),
             Contains("<halfSpace>: the attribute normal is missing"));
  CHECK_THAT(messageOf("<region count=\"2\"><beyond point=\"12 8 8\" direction=\"0 0 0\"/></region>"),
             Contains("config.xml:8: <beyond>: its direction 0 0 0 is not a direction"));
  CHECK_THAT(messageOf("<region count=\"2\"><beyond point=\"12 8 80\" direction=\"1 0 0\"/></region>"),
             Contains("config.xml:8: <beyond>: the point (12, 8, 80) is not in the lumen"));
  CHECK_THAT(messageOf("<region count=\"2\"><beyond point=\"12 8 nan\" direction=\"1 0 0\"/></region>"),
             Contains("expected three numbers"));
  CHECK_THAT(messageOf("<region count=\"2\"><halfSpace point=\"99 8 8\" normal=\"1 0 0\"/></region>"),
             Contains("config.xml:8: <halfSpace>: this region lies outside the lumen"));
  CHECK_THAT(messageOf("<region>" + ball + "<species name=\"PLT\"/></region>"),
             Contains("<species>: the attribute count is missing"));
  CHECK_THAT(messageOf("<region>" + ball +
                       "<species name=\"PLT\" count=\"1\"/><species name=\"PLT\" count=\"2\"/></region>"),
             Contains("<region>: a second species called 'PLT'"));
  CHECK_THAT(messageOf("<region>" + ball + "<species name=\"WBC\" count=\"1\"/></region>",
                       "<hematocrit>0.1</hematocrit>"),
             Contains("WBC.xml: no such file"));
  CHECK_THAT(messageOf("<region count=\"4\">" + ball + "</region>", "<species name=\"RBC\" count=\"3\"/>"),
             Contains("take more red cells than there are: 3 'RBC'"));
  CHECK_THAT(messageOf("<region count=\"2\">" + ball + "<species name=\"RBC\" count=\"3\"/></region>"),
             Contains("<sphere>: its own red cells are more than its count allows"));
  CHECK_THAT(messageOf("<container><halfSpace point=\"1 2 3\" normal=\"1 0 0\"/></container>"),
             Contains("<halfSpace>: unknown tag"));
}

TEST_CASE("Invalid constraints are rejected", "[regions]") {
  const SampleCase folder;
  const auto messageOf = [&](const std::string& packing, const std::string& arguments = "") {
    writeText(folder / "config.xml", configXml(sampleDomain, "<packing>" + packing + "</packing>"));
    const Ran refusal = run(folder, "config.xml " + arguments);
    CHECK((refusal.exitCode == 1 || refusal.exitCode == 2));
    return refusal.err;
  };
  const std::string ball = "<sphere radius=\"3\" center=\"12 8 8\"/>";
  CHECK_THAT(messageOf("<hematocrit>0.1</hematocrit><region> " + ball + "</region>"),
             Contains("attribute hematocrit is missing"));
  CHECK_THAT(messageOf("<hematocrit>0.1</hematocrit><region hematocrit=\"0.2\"/>"),
             Contains("expected one body"));
  CHECK_THAT(messageOf("<hematocrit>0.1</hematocrit><region hematocrit=\"1\">" + ball + "</region>"),
             Contains("[0, 1)"));
  CHECK_THAT(messageOf("<region hematocrit=\"0.2\">" + ball + "</region>", "--rbc 3"),
             Contains("regions require a hematocrit of the rest"));
  CHECK_THAT(messageOf("<hematocrit>0.1</hematocrit><region hematocrit=\"0.2\"><sphere radius=\"3\" "
                       "center=\"99 8 8\"/></region>"),
             Contains("outside the lumen"));
  CHECK_THAT(messageOf("<species name=\"RBC\" count=\"3\" axis=\"0 0 0\"/>"), Contains("is not a direction"));
  CHECK_THAT(messageOf("<species name=\"RBC\" count=\"3\" spread=\"3\"/>"), Contains("no axis"));
  CHECK_THAT(messageOf("<species name=\"RBC\" count=\"3\" axis=\"0 0 1\" spread=\"91\"/>"),
             Contains("[0, 90]"));
  CHECK_THAT(messageOf("<species name=\"RBC\" count=\"3\"/><export>vrml</export>"),
             Contains("csv, espresso, "));
  CHECK_THAT(messageOf("<species name=\"RBC\" count=\"3\"/>", "--tile 2 1 1"),
             Contains("is for periodic boxes"));
}

TEST_CASE("Options of constraints are validated", "[regions]") {
  const TemporaryFolder folder;
  writeText(folder / "RBC.pos", "1\n5 5 5 0 0\n");
  for (const RefusedRow& row : std::vector<RefusedRow>{
           {"--cell-free-layer -1", 1, "'--cell-free-layer': expected a number in [0, 100]"},
           {"--cell-free-layer 10", 2, "larger than the lumen"},
           {"--orient RBC 0 0 0 10", 2, "is not a direction"},
           {"--orient RBC 0 0 1", 1, "the angle is missing"},
           {"--orient RBC 0 0 1 100", 1, "[0, 90]"},
           {"--orient WBC 0 0 1 10", 1, "no such cells to pack"},
           {"--start RBC.pos", 2, "RBC.pos:2"},
           {"--start none.pos", 2, "none.pos"},
           {"--export vrml", 1, "csv, espresso, "},
           {"--stock RBC -1", 1, "expected a whole number"},
           {"--realisations 2 --restart x.h5", 1, "continue from the state of one of them"},
           {"--realisations 2 --seed 9223372036854775807", 1, "larger than a seed may be"},
           {"--start RBC.pos --fixed ./RBC.pos", 2, "cannot be both fixed (fixed) and movable (start)"},
           {"--orient RBC 0 0 1 20 --noRotate", 2, "keeps every orientation at 0 0 0"},
           {"--walls none --cell-free-layer 1", 2, "this lumen has none"},
           {"--order columns", 2, "periodic along all axes"},
           {"--order rows", 1, "random or columns"},
           {"--order columns --walls none --ends periodic --noRotate", 2, "rotations are disabled"},
           {"--pre-inlet Xpos", 2, "lengthN"},
           {"--tile 2 2", 1, "the nz is missing"}}) {
    const bool ownWalls = Catch::contains(row.arguments, "--walls");
    requireRefused(folder,
                   {{"16 16 16 --rbc 2 " + std::string(ownWalls ? "" : "--walls xyz ") + row.arguments,
                     row.exitCode, row.message}});
  }
}
