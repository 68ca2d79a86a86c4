// SPDX-License-Identifier: AGPL-3.0-or-later
// Lumens: vessels, boxes and bodies of the command line and of the configuration, with the real executable.

#include "hemocell_adapter/hemocell/cell_model.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "tests/hemocell_adapter/refusal.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

namespace {

/// What a run says of the lumen.
std::string lumenLine(const std::string& out) {
  const std::size_t at = out.find("Lumen: ");
  return at == out.npos ? "" : out.substr(at, out.find('\n', at) - at);
}

}  // namespace

TEST_CASE("Periodic ends apply to packing and to check", "[executable]") {
  const SampleCase folder("<packing> <ends> periodic </ends> <hematocrit> 0.4 </hematocrit> </packing>");
  const Ran ran = ok(folder, "config.xml");
  CHECK(lumenLine(ran.out).find("periodic along x") != std::string::npos);
  CHECK_THAT(ok(folder, "check config.xml").out, Contains("Verdict: clean. HemoCell will delete "));

  // 24 µm of tube at dx 0.5 µm are 51 nodes: the ends are at -0.25 and 25.25 µm.
  // No cell is thinner than 2.2 µm.
  constexpr double lo = -0.25, period = 25.5, half = 1.1;
  const std::string file = readText(folder / "RBC.pos");
  std::istringstream in(file);
  int count = 0, crossing = 0;
  std::string line, image;
  in >> count;
  std::getline(in, line);
  while (std::getline(in, line)) {
    const std::size_t end = line.find(' ');
    const double x = std::stod(line.substr(0, end));
    CHECK((x >= lo && x < lo + period));
    if (x - lo > half && lo + period - x > half) continue;
    ++crossing;
    image = std::to_string(x < lo + half ? x + period : x - period) + line.substr(end);
  }
  REQUIRE(crossing > 0);
  const Ran closed =
      ended(folder, 4, "check config.xml --ends closed");  // the cells across the ends are dropped
  CHECK_THAT(closed.out, Contains("meets an end of the vessel"));

  // The image of a cell that crosses an end is where the cell is.
  writeText(folder / "RBC.pos", rbcPos(file.substr(file.find('\n') + 1) + image + "\n", count + 1));
  CHECK_THAT(ended(folder, 4, "check config.xml").out,
             Contains("Overlapping pairs: 1") && Contains("periodic image"));
}

TEST_CASE("Packing and check use the same lumen", "[executable]") {
  const SampleCase folder;
  const std::string box = "<dx>5e-7</dx><nx>40</nx><ny>42</ny><nz>44</nz>";
  const std::string cylinder =
      "<packing><container><cylinder radius=\"9\" length=\"20\"/></container></packing>";
  struct Row {
    std::string domain, packing, options;
  };
  for (const Row& row : std::vector<Row>{{sampleDomain, "", ""},
                                         {sampleDomain, "", "--ends periodic"},
                                         {sampleDomain, "<packing><ends>periodic</ends></packing>", ""},
                                         {box, "", "--walls yz"},
                                         {box, "", "--walls yz --ends periodic"},
                                         {box, cylinder, ""}}) {
    writeText(folder / "config.xml", configXml(row.domain, row.packing));
    const Ran packed = run(folder, "config.xml --rbc 3 " + row.options);
    const Ran checked = run(folder, "check config.xml " + row.options);
    INFO(row.domain << row.packing << row.options << "\n" << packed.all() << checked.all());
    CHECK(packed.exitCode == 0);
    CHECK(checked.exitCode == 0);
    CHECK(lumenLine(packed.out).size() > 20);
    CHECK(lumenLine(packed.out) == lumenLine(checked.out));
  }
}

TEST_CASE("The planes of the walls of a box are solid nodes", "[executable]") {
  const TemporaryFolder folder;
  CHECK_THAT(ok(folder, "20 20 12 --rbc 20 --walls z").out, Contains("HemoCell keeps 20 of 20"));
  const TriangleMesh cell = buildTemplate(*defaultModel("RBC"), 0.5);
  Box all;
  for (const PosLine& line : readPos(folder / "RBC.pos"))
    for (const Vec3& v : placed(cell, placementOf(line)).vertices) all.add(v);
  CHECK(all.lo.z() > 0.25);  // node 0 is solid up to half a node from it
  CHECK(all.hi.z() < 11.75);
  CHECK(all.lo.minCoeff() > -0.25);
  CHECK(all.hi.maxCoeff() <= 19.75);
  ok(folder, "check --box 20 20 12 --walls z");
  writeText(folder / "RBC.pos", rbcPos("4 1.2 4 0 0 0\n", 1));  // nearer to the wall than half a node
  ended(folder, 4, "check --box 20 20 12 --walls xyz");
  // Cells may cross the other faces when that is asked for, and what it costs is said.
  CHECK_THAT(ok(folder, "20 20 12 --rbc 22 --walls z --ends periodic --seed 2").out,
             Contains("crosses a periodic face"));
}

TEST_CASE("Boxes are packed under both program names", "[executable]") {
  const TemporaryFolder folder;
  Ran ran = ended(folder, 0, "50 50 50 --hematocrit 0.3", "packCells");
  CHECK(cellsIn(folder / "RBC.pos") == 387);
  CHECK(cellsIn(folder / "PLT.pos") == 27);
  ran = ended(folder, 0, "50.9 50 50 -h 0.3", "packCells");
  CHECK_THAT(ran.err, Contains("size 50.9 is read as 50"));
  CHECK_THAT(ended(folder, 1, "0.9 50 50 -h 0.3", "packCells").err, Contains("size 0.9 is read as 0"));
  CHECK(cellsIn(folder / "RBC.pos") == 387);
  ran = ok(folder, "check --box 50 50 50 --ends periodic");
  ended(folder, 4, "check --box 50 50 50");

  ran = ok(folder, "25.5 25 25 --hematocrit 0.3 --plt_ratio 0");
  CHECK(cellsIn(folder / "RBC.pos") == 59);  // 0.3 · 25.5 · 25 · 25 / 81.116 = 58.94
  CHECK_THAT(ran.err, Contains("PLT.pos is not part of this packing"));
  CHECK_THAT(ran.out, Contains("HemoCell keeps"));
  ran = run(folder, "25.5 25 25 --hematocrit 0.3 --plt_ratio 0 --rbc-volume 97");
  CHECK(cellsIn(folder / "RBC.pos") == 49);
  ran = ok(folder, "25 25 25 --rbc 50");
  CHECK_THAT(ran.out, Contains("HemoCell keeps 50 of 50"));
}

TEST_CASE("Containers of the command line and of the configuration are packed", "[executable]") {
  const SampleCase folder;
  for (const char* arguments :
       {"--cylinder x 10 20 --rbc 12", "--cylinder z 10 20 --ends periodic --rbc 12", "--sphere 10 --rbc 8",
        "20 20 20 --walls xyz --rbc 15", "--vessel tube.stl 10 --rbc 8",
        "--vessel tube.stl 10 --open-axis x --ends periodic --rbc 8"}) {
    CHECK_THAT(ok(folder, arguments).out, Contains("Certificate: clean"));
  }
  const auto packed = [&](const std::string& domain, const std::string& container,
                          const std::string& options) {
    writeText(folder / "config.xml",
              configXml(domain, container.empty() ? "" : "<packing>" + container + "</packing>"));
    const Ran ran = run(folder, "config.xml " + options);
    INFO(domain << container << options << "\n" << ran.all());
    CHECK(ran.exitCode == 0);
    ok(folder,
       "check config.xml " +
           (options.find("--walls") != std::string::npos ? options.substr(options.find("--walls")) : ""));
  };
  const std::string box = "<dx>5e-7</dx><nx>40</nx><ny>42</ny><nz>44</nz>";
  packed(box, "", "--hematocrit 0.3 --walls yz");
  packed(box, "", "--hematocrit 0.3 --walls none");
  packed(box,
         "<walls>yz</walls><container><obstacles><cylinder axis=\"z\" center=\"10 10 11\" radius=\"3\" "
         "length=\"30\"/></obstacles></container>",
         "--hematocrit 0.2");
  packed("<dx>5e-7</dx><geometry>missing.stl</geometry><refDir>0</refDir><refDirN>10</refDirN>",
         "<container><cylinder radius=\"9\" length=\"20\"/></container>", "--hematocrit 0.2");
}

TEST_CASE("An inverted STL with triangles without area is packed as HemoCell fills it", "[executable]") {
  const SampleCase folder;
  // The tube, with a vertex on a long edge of which only one of the two facets knows: a third one without
  // area fills the gap.
  std::istringstream lines(tubeStl(2.4, 0.75, 48));
  std::vector<std::string> points;
  for (std::string line; std::getline(lines, line);)
    if (line.rfind("vertex ", 0) == 0) points.push_back(line.substr(7));
  const auto facet = [](const std::string& a, const std::string& b, const std::string& c) {
    return "facet normal 0 0 0\nouter loop\nvertex " + c + "\nvertex " + b + "\nvertex " + a +
           "\nendloop\nendfacet\n";
  };
  // Facets 0 and 1 are (p, q, r) and (p, r, s); p and s, at (0, 0.75, 0) and (2.4, 0.75, 0), end an edge.
  const std::string p = points[0], q = points[1], r = points[2], s = points[5], middle = "1 0.75 0";
  std::string stl =
      "solid t\n" + facet(p, q, r) + facet(p, r, middle) + facet(middle, r, s) + facet(p, middle, s);
  for (std::size_t k = 6; k + 2 < points.size(); k += 3)
    stl += facet(points[k], points[k + 1], points[k + 2]);
  writeText(folder / "tube.stl", stl + "endsolid t\n");
  const Ran packed = ok(folder, "config.xml --hematocrit 0.2");
  CHECK_THAT(packed.err, Contains("repaired 1 triangle without area") && Contains("inside out"));
  // HemoCell deflates this one: a node fewer along each axis than of the sound tube.
  CHECK_THAT(packed.out, Contains("of 50 x 32 x 32"));
  ok(folder, "check config.xml");
}

TEST_CASE("An STL that had to be repaired gives a warning about HemoCell", "[executable]") {
  const SampleCase folder;
  std::string stl = tubeStl(2.4, 0.75, 48);
  CHECK(run(folder, "config.xml --rbc 3").err.empty());
  const std::size_t facet = stl.find("vertex"), next = stl.find("vertex", facet + 1),
                    last = stl.find("vertex", next + 1);
  const std::string first = stl.substr(facet, next - facet), second = stl.substr(next, last - next);
  stl.replace(facet, last - facet, second + first);
  writeText(folder / "tube.stl", stl);
  CHECK_THAT(ok(folder, "config.xml --rbc 3").err,
             Contains("flipped 1 triangle") && Contains("HemoCell reads the file as it is"));

  writeText(folder / "tube.stl", tubeStl(-2.4, 0.75, 48));  // mirrored: inside out
  CHECK_THAT(ok(folder, "config.xml --rbc 3").err, Contains("flipped 1 surface that was inside out") &&
                                                       Contains("HemoCell reads the file as it is"));
  ok(folder, "check config.xml");
}

TEST_CASE("Cells longer than a periodic box are packed, since their images can lie side by side",
          "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "30 30 30 --ends periodic --cell Rod 1 60 2 2");
}

TEST_CASE("Cutting a box to whole lattice spacings is reported", "[executable]") {
  const TemporaryFolder folder;
  CHECK_THAT(ok(folder, "8.4 9 10 --rbc 1").out,
             Contains("8.4 x 9 x 10 µm requested, truncated to whole lattice spacings"));
  CHECK_THAT(ok(folder, "8.5 9 10 --rbc 1").out, !Contains("requested, truncated"));
}

TEST_CASE("A wall clearance without a wall gives a warning", "[executable]") {
  const TemporaryFolder folder;
  CHECK_THAT(ok(folder, "20 20 20 --rbc 2 --ends periodic --wall-clearance 1").err, Contains("has no wall"));
}
