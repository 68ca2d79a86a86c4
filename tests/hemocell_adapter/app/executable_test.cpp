// SPDX-License-Identifier: AGPL-3.0-or-later
// What users do, done with the real executable.
#include <fmt/format.h>
#include <sys/stat.h>

#include <catch2/catch.hpp>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/hemocell/cell_model.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/settings/settings_table.h"
#include "sample_case.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
using Catch::Matchers::Contains;
using packmesh::hemocell::ExitCode;
namespace fs = std::filesystem;

namespace {

int cellsIn(const fs::path& file) {
  std::ifstream in(file);
  int n = -1;
  in >> n;
  return n;
}

/// What a run says of the lumen.
std::string lumenLine(const std::string& out) {
  const std::size_t at = out.find("Lumen: ");
  return at == out.npos ? "" : out.substr(at, out.find('\n', at) - at);
}

}  // namespace

TEST_CASE("the clearances asked for are kept, between cells and to the wall", "[executable]") {
  const SampleCase folder;
  const Ran packed = run(folder.path(), "config.xml --hematocrit 0.25 --clearance 0.1 --wall-clearance 0.4");
  INFO(packed.all());
  REQUIRE(packed.exitCode == 0);
  const auto gapAfter = [](const std::string& text, const std::string& words) {
    const std::size_t at = text.find(words);
    REQUIRE(at != text.npos);
    return std::stod(text.substr(at + words.size()));
  };
  CHECK(gapAfter(packed.out, "minimum gap ") >= 0.1);
  CHECK(gapAfter(packed.out, "to the wall ") >= 0.4);
  CHECK(gapAfter(packed.out, "to the wall ") < 0.6);

  const Ran checked = run(folder.path(), "check config.xml");
  INFO(checked.all());
  CHECK(checked.exitCode == 0);
  CHECK(gapAfter(checked.out, "Minimum gap to the wall: ") == gapAfter(packed.out, "to the wall "));
}

TEST_CASE("check judges the clearances asked for", "[executable]") {
  const TemporaryFolder folder;
  const std::string tube = "--cylinder x 8 30 ";
  REQUIRE(run(folder.path(), tube + "--rbc 9 --clearance 0.2 --wall-clearance 0.3").exitCode == 0);
  for (const auto& [asked, exitCode] :
       std::vector<std::pair<std::string, ExitCode>>{{"", ExitCode::ok},
                                                     {"--clearance 0.2 --wall-clearance 0.3", ExitCode::ok},
                                                     {"--clearance 8", ExitCode::faultsFound},
                                                     {"--wall-clearance 6", ExitCode::faultsFound},
                                                     {"--cell-free-layer 6", ExitCode::faultsFound}}) {
    const Ran ran = run(folder.path(), "check " + tube + asked);
    INFO(asked + "\n" + ran.all());
    CHECK(ran.exitCode == int(exitCode));
  }
  CHECK_THAT(run(folder.path(), "check " + tube + "--clearance 8").out,
             Contains("Overlapping pairs or nearer than 8 µm: ") && Contains(" µm apart\n") &&
                 Contains("Minimum gap: ") && !Contains("cells overlap"));
}

TEST_CASE("a case is packed, certified, and HemoCell keeps all of it", "[executable]") {
  const SampleCase folder;
  const Ran packed = run(folder.path(), "config.xml --hematocrit 0.30 --plt_ratio 0.2 --seed 3");
  INFO(packed.all());
  REQUIRE(packed.exitCode == 0);
  const int rbc = cellsIn(folder.path() / "RBC.pos"), plt = cellsIn(folder.path() / "PLT.pos");
  CHECK(rbc > 10);
  CHECK(plt == std::lround(0.2 * rbc));
  CHECK_THAT(packed.out,
             Contains("HemoCell keeps " + std::to_string(rbc + plt) + " of " + std::to_string(rbc + plt)));
  CHECK_THAT(packed.out, Contains("Certificate: clean"));
  CHECK_THAT(packed.out, Contains("packCells"));
  CHECK_THAT(packed.out, Contains("<Volume>"));

  const Ran checked = run(folder.path(), "check config.xml");
  INFO(checked.all());
  CHECK(checked.exitCode == 0);
  CHECK_THAT(checked.out, Contains("Verdict: clean"));
  CHECK_THAT(checked.out, Contains("minimum distance from solid 0 µm (not set in case.cpp)"));

  // Same seed, same bytes; another seed, another packing.
  const std::string first = readText(folder.path() / "RBC.pos");
  CHECK(run(folder.path(), "config.xml --hematocrit 0.30 --plt_ratio 0.2 --seed 3").exitCode == 0);
  CHECK(readText(folder.path() / "RBC.pos") == first);
  CHECK(run(folder.path(), "config.xml --hematocrit 0.30 --plt_ratio 0.2 --seed 4").exitCode == 0);
  CHECK(readText(folder.path() / "RBC.pos") != first);
}

TEST_CASE("the packing section alone suffices, options override it", "[executable]") {
  const SampleCase folder(
      "<packing> <hematocrit> 0.2 </hematocrit> <species name=\"RBC\" minimumDistanceFromSolid=\"1\"/> "
      "</packing>");
  const Ran ran = run(folder.path(), "config.xml");
  INFO(ran.all());
  REQUIRE(ran.exitCode == 0);
  const int n = cellsIn(folder.path() / "RBC.pos");
  CHECK_FALSE(fs::exists(folder.path() / "PLT.pos"));
  CHECK_THAT(ran.out, Contains("minimum distance from solid 1 µm"));
  CHECK(run(folder.path(), "check config.xml").exitCode == 0);
  CHECK(run(folder.path(), "config.xml --hematocrit 0.1").exitCode == 0);
  CHECK(cellsIn(folder.path() / "RBC.pos") < n);
  CHECK(run(folder.path(), "config.xml --rbc 3").exitCode == 0);
  CHECK(cellsIn(folder.path() / "RBC.pos") == 3);
  CHECK(run(folder.path(), "config.xml --output-dir new/folder").exitCode == 0);
  CHECK(cellsIn(folder.path() / "new/folder/RBC.pos") == n);
}

TEST_CASE("periodic ends: packed across them, and checked across them", "[executable]") {
  const SampleCase folder("<packing> <ends> periodic </ends> <hematocrit> 0.4 </hematocrit> </packing>");
  const Ran ran = run(folder.path(), "config.xml");
  INFO(ran.all());
  REQUIRE(ran.exitCode == 0);
  CHECK(lumenLine(ran.out).find("periodic along x") != std::string::npos);
  const Ran checked = run(folder.path(), "check config.xml");
  CHECK(checked.exitCode == 0);
  CHECK_THAT(checked.out, Contains("Verdict: clean; that HemoCell drops "));

  // 24 µm of tube at dx 0.5 µm are 51 nodes: the ends are at -0.25 and 25.25 µm.
  // No cell is thinner than 2.2 µm.
  constexpr double lo = -0.25, period = 25.5, half = 1.1;
  const std::string file = readText(folder.path() / "RBC.pos");
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
  const Ran closed = run(folder.path(), "check config.xml --ends closed");
  INFO(closed.all());
  CHECK(closed.exitCode == 4);  // the cells across the ends are dropped
  CHECK_THAT(closed.out, Contains("meets an end of the vessel"));

  // The image of a cell that crosses an end is where the cell is.
  writeText(folder.path() / "RBC.pos", rbcPos(file.substr(file.find('\n') + 1) + image + "\n", count + 1));
  const Ran twice = run(folder.path(), "check config.xml");
  INFO(twice.all());
  CHECK(twice.exitCode == 4);
  CHECK_THAT(twice.out, Contains("Overlapping pairs: 1") && Contains("periodic image"));
}

TEST_CASE("packing and check speak of the same lumen", "[executable]") {
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
    writeText(folder.path() / "config.xml", configXml(row.domain, row.packing));
    const Ran packed = run(folder.path(), "config.xml --rbc 3 " + row.options);
    const Ran checked = run(folder.path(), "check config.xml " + row.options);
    INFO(row.domain << row.packing << row.options << "\n" << packed.all() << checked.all());
    CHECK(packed.exitCode == 0);
    CHECK(checked.exitCode == 0);
    CHECK(lumenLine(packed.out).size() > 20);
    CHECK(lumenLine(packed.out) == lumenLine(checked.out));
  }
}

TEST_CASE("a box between walls: the planes of the walls are solid nodes", "[executable]") {
  const TemporaryFolder folder;
  const Ran ran = run(folder.path(), "20 20 12 --rbc 20 --walls z");
  INFO(ran.all());
  REQUIRE(ran.exitCode == 0);
  CHECK_THAT(ran.out, Contains("HemoCell keeps 20 of 20"));
  const TriangleMesh cell = buildTemplate(*defaultModel("RBC"), 0.5);
  Box all;
  for (const PosLine& line : readPos(folder.path() / "RBC.pos"))
    for (const Vec3& v : placed(cell, placementOf(line)).vertices) all.add(v);
  CHECK(all.lo.z() > 0.25);  // node 0 is solid up to half a node from it
  CHECK(all.hi.z() < 11.75);
  CHECK(all.lo.minCoeff() > -0.25);
  CHECK(all.hi.maxCoeff() <= 19.75);
  CHECK(run(folder.path(), "check --box 20 20 12 --walls z").exitCode == 0);
  writeText(folder.path() / "RBC.pos", rbcPos("4 1.2 4 0 0 0\n", 1));  // nearer to the wall than half a node
  CHECK(run(folder.path(), "check --box 20 20 12 --walls xyz").exitCode == 4);
  // Cells may cross the other faces when that is asked for, and what it costs is said.
  const Ran whole = run(folder.path(), "20 20 12 --rbc 22 --walls z --ends periodic --seed 2");
  CHECK(whole.exitCode == 0);
  CHECK_THAT(whole.out, Contains("a vertex lies outside"));
}

TEST_CASE("growth as the method: a case with voxel walls, a box, and what does not fit it", "[executable]") {
  const SampleCase folder("<packing> <method> cat </method> <builder> chords </builder> </packing>");
  const Ran packed = run(folder.path(), "config.xml --hematocrit 0.30 --plt_ratio 0.2 --seed 3 --verbose");
  INFO(packed.all());
  REQUIRE(packed.exitCode == 0);
  const int rbc = cellsIn(folder.path() / "RBC.pos"), plt = cellsIn(folder.path() / "PLT.pos");
  CHECK(rbc > 10);
  CHECK_THAT(packed.out,
             Contains("HemoCell keeps " + std::to_string(rbc + plt) + " of " + std::to_string(rbc + plt)));
  CHECK_THAT(packed.out, Contains("Certificate: clean"));
  CHECK_THAT(packed.out, Contains("Method: growth"));
  CHECK_THAT(packed.out, Contains("iterations"));
  CHECK(run(folder.path(), "check config.xml").exitCode == 0);
  const std::string first = readText(folder.path() / "RBC.pos");
  CHECK(run(folder.path(), "config.xml --hematocrit 0.30 --plt_ratio 0.2 --seed 3").exitCode == 0);
  CHECK(readText(folder.path() / "RBC.pos") == first);
  CHECK(run(folder.path(), "config.xml --hematocrit 0.30 --plt_ratio 0.2 --method relaxation").exitCode == 2);

  const TemporaryFolder box;
  Ran ran = run(box.path(), "16 16 16 --hematocrit 0.35 --plt_ratio 0 --method cat");
  INFO(ran.all());
  CHECK(ran.exitCode == 0);
  CHECK(run(box.path(), "check --box 16 16 16").exitCode == 0);
  ran = run(box.path(), "16 16 16 --hematocrit 0.35 --method cat --max-iterations 3");
  CHECK(ran.exitCode == 3);
  CHECK_THAT(ran.err, Contains("3 iterations of growth"));
  ran = run(box.path(), "16 16 16 --hematocrit 0.35 --method dog");
  CHECK(ran.exitCode == 1);
  CHECK_THAT(ran.err, Contains("cat"));
  ran = run(box.path(), "16 16 16 --hematocrit 0.35 --builder chords");
  CHECK(ran.exitCode == 1);
  CHECK_THAT(ran.err, Contains("'--builder' is for --method cat"));
  ran = run(box.path(), "16 16 16 --hematocrit 0.35 --escape");
  CHECK(ran.exitCode == 1);
  CHECK_THAT(ran.err, Contains("'--escape' is for --method cat"));
  for (const std::string builder : {"tetgen", "cat-faces"}) {
    ran =
        run(box.path(), "10 10 10 --rbc 2 --walls xyz --method cat --escape --verbose --builder " + builder);
    INFO(ran.all());
    CHECK(ran.exitCode == 0);
    CHECK_THAT(ran.out, Contains("tetrahedra"));
    CHECK_THAT(ran.out, Contains("attempts of TetGen"));
  }
}

TEST_CASE("the executable passes on the parameters of growth", "[executable]") {
  const TemporaryFolder folder;
  const std::string command = "12 12 12 --rbc 3 --method cat ";
  const auto posOf = [&](const std::string& arguments) {
    const Ran ran = run(folder.path(), command + arguments);
    INFO(ran.all());
    REQUIRE(ran.exitCode == 0);
    return readText(folder.path() / "RBC.pos");
  };
  const std::string plain = posOf("");
  // Each of them changes the packing; the values of a table's fallbacks do not.
  for (const GrowthParameter& parameter : growthParameters()) {
    CAPTURE(parameter.name);
    CHECK(posOf(fmt::format("--growth {} '{}'", parameter.name, parameter.fallback)) == plain);
  }
  for (const char* other :
       {"initialScale 0.2", "barriers '0.6 1'", "rotationBound 0.1", "translationBound 0.1", "padding 0.5",
        "linearisations 1", "alpha 1", "beta 1e-9", "centring no", "shaking 0.1"}) {
    CAPTURE(other);
    CHECK(posOf(std::string("--growth ") + other) != plain);
  }
  Ran ran = run(folder.path(), command + "--growth iterations 1 --growth barriers 1");
  CHECK(ran.exitCode == 3);
  ran = run(folder.path(), command + "--growth iterations 0");
  CHECK(ran.exitCode == 1);
  CHECK_THAT(ran.err, Contains("'--growth' iterations: expected a whole number"));
  ran = run(folder.path(), command + "--growth barriers '0.5 0.9'");
  CHECK(ran.exitCode == 2);
  CHECK_THAT(ran.err, Contains("the last barrier must be 1"));
  ran = run(folder.path(), command + "--growth paddding 1");
  CHECK(ran.exitCode == 1);
  CHECK_THAT(ran.err, Contains("did you mean 'padding'?"));
  ran = run(folder.path(), "12 12 12 --rbc 3 --growth padding 0.5");
  CHECK(ran.exitCode == 1);
  CHECK_THAT(ran.err, Contains("'--growth' is for --method cat"));
}

TEST_CASE("escaping fills gaps from a stock", "[executable]") {
  const TemporaryFolder folder;
  const std::string command = "12 12 12 --rbc 5 --plt 2 --method cat --stock PLT 4 ";
  Ran ran = run(folder.path(), command + "--escape --state state.h5");
  INFO(ran.all());
  REQUIRE(ran.exitCode == 0);
  CHECK(cellsIn(folder.path() / "RBC.pos") == 5);
  const std::string platelets = readText(folder.path() / "PLT.pos");
  CHECK(cellsIn(folder.path() / "PLT.pos") == 6);
  CHECK_THAT(ran.out, Contains("PLT: 6 of 2 and 4 in stock placed"));
  CHECK(run(folder.path(), "check --box 12 12 12").exitCode == 0);
  std::filesystem::remove(folder.path() / "PLT.pos");
  CHECK(run(folder.path(), "--restart state.h5").exitCode == 0);
  CHECK(readText(folder.path() / "PLT.pos") == platelets);
  ran = run(folder.path(), command);
  CHECK(ran.exitCode == 2);
  CHECK_THAT(ran.err, Contains("'PLT' has a stock, which only --escape uses"));
}

TEST_CASE("boxes, under both names", "[executable]") {
  const TemporaryFolder folder;
  Ran ran = run(folder.path(), "50 50 50 --hematocrit 0.3", "packCells");
  INFO(ran.all());
  REQUIRE(ran.exitCode == 0);
  CHECK(cellsIn(folder.path() / "RBC.pos") == 387);
  CHECK(cellsIn(folder.path() / "PLT.pos") == 27);
  ran = run(folder.path(), "50.9 50 50 -h 0.3", "packCells");
  CHECK(ran.exitCode == 0);
  CHECK_THAT(ran.err, Contains("size 50.9 is read as 50"));
  ran = run(folder.path(), "0.9 50 50 -h 0.3", "packCells");
  CHECK(ran.exitCode == 1);
  CHECK_THAT(ran.err, Contains("size 0.9 is read as 0"));
  CHECK(cellsIn(folder.path() / "RBC.pos") == 387);
  ran = run(folder.path(), "check --box 50 50 50 --ends periodic");
  INFO(ran.all());
  CHECK(ran.exitCode == 0);
  CHECK(run(folder.path(), "check --box 50 50 50").exitCode == 4);

  ran = run(folder.path(), "25.5 25 25 --hematocrit 0.3 --plt_ratio 0");
  CHECK(ran.exitCode == 0);
  CHECK(cellsIn(folder.path() / "RBC.pos") == 59);  // 0.3 · 25.5 · 25 · 25 / 81.116 = 58.94
  CHECK_THAT(ran.err, Contains("PLT.pos is not part of this packing"));
  CHECK_THAT(ran.out, Contains("HemoCell keeps"));
  ran = run(folder.path(), "25.5 25 25 --hematocrit 0.3 --plt_ratio 0 --rbc-volume 97");
  CHECK(cellsIn(folder.path() / "RBC.pos") == 49);
  ran = run(folder.path(), "25 25 25 --rbc 50");
  INFO(ran.all());
  CHECK(ran.exitCode == 0);
  CHECK_THAT(ran.out, Contains("HemoCell keeps 50 of 50"));
}

TEST_CASE("containers of the command line and of the configuration", "[executable]") {
  const SampleCase folder;
  for (const char* arguments :
       {"--cylinder x 10 20 --rbc 12", "--cylinder z 10 20 --ends periodic --rbc 12", "--sphere 10 --rbc 8",
        "20 20 20 --walls xyz --rbc 15", "--vessel tube.stl 10 --rbc 8",
        "--vessel tube.stl 10 --open-axis x --ends periodic --rbc 8"}) {
    const Ran ran = run(folder.path(), arguments);
    INFO(arguments << "\n" << ran.all());
    CHECK(ran.exitCode == 0);
    CHECK_THAT(ran.out, Contains("Certificate: clean"));
  }
  const auto packed = [&](const std::string& domain, const std::string& container,
                          const std::string& options) {
    writeText(folder.path() / "config.xml",
              configXml(domain, container.empty() ? "" : "<packing>" + container + "</packing>"));
    const Ran ran = run(folder.path(), "config.xml " + options);
    INFO(domain << container << options << "\n" << ran.all());
    CHECK(ran.exitCode == 0);
    const Ran checked =
        run(folder.path(), "check config.xml " + (options.find("--walls") != std::string::npos
                                                      ? options.substr(options.find("--walls"))
                                                      : ""));
    INFO(checked.all());
    CHECK(checked.exitCode == 0);
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

TEST_CASE("cells of one's own", "[executable]") {
  const SampleCase folder;
  const Ran ran =
      run(folder.path(),
          "20 20 20 --cell egg 5 3 4 5 --cell-mesh rod 4 tube.stl --mesh-scale rod 3 --vrbc 2 --wbc 1");
  INFO(ran.all());
  CHECK(ran.exitCode == 0);
  CHECK(cellsIn(folder.path() / "egg.pos") == 5);
  CHECK(cellsIn(folder.path() / "rod.pos") == 4);
  CHECK(run(folder.path(),
            "check --box 20 20 20 --cell egg 5 3 4 5 --cell-mesh rod 4 tube.stl --mesh-scale rod 3")
            .exitCode == 0);
}

TEST_CASE("a mesh of a cell (--cell-mesh) is packed as a case with that STL simulates it", "[executable]") {
  const SampleCase folder;
  writeText(folder.path() / "rod.stl", tubeStl(6, 1, 12));
  std::string xml = cellXml("rod", 3, 600, "<StlFile> rod.stl </StlFile>");
  writeText(folder.path() / "rod.xml", xml);
  writeText(folder.path() / "box.xml", configXml("<dx> 5e-7 </dx> <nx> 32 </nx> <ny> 32 </ny> <nz> 32 </nz>",
                                                 "<packing> <walls> none </walls> </packing>"));
  const std::string pack = "16 16 16 --keep-all --cell-mesh rod 60 rod.stl --output-dir box";
  const Ran packed = run(folder.path(), pack);
  CHECK(packed.exitCode == 0);
  CHECK_THAT(packed.out, Contains("rod.stl, MESH_FROM_STL"));
  const Ran checked = run(folder.path(), "check box.xml --output-dir box");
  INFO(checked.all());
  CHECK(checked.exitCode == 0);
  CHECK_THAT(checked.out, Contains("HemoCell keeps 60 of 60 rod"));

  const Ran other = run(folder.path(), pack + " --mesh-frame rod file");
  CHECK(other.exitCode == 0);
  CHECK_THAT(other.out, Contains("rod.stl, axes of the file"));
  CHECK(run(folder.path(), "check box.xml --output-dir box").exitCode == 4);
  CHECK(run(folder.path(), "check box.xml --output-dir box --cell-mesh rod 60 rod.stl --mesh-frame rod file")
            .exitCode == 0);
  CHECK_THAT(run(folder.path(), "9 9 9 --rbc 1 --mesh-frame RBC file").err, Contains("no mesh file"));
}

TEST_CASE("a case whose STL has triangles without area and is inside out is packed as HemoCell fills it",
          "[executable]") {
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
  writeText(folder.path() / "tube.stl", stl + "endsolid t\n");
  const Ran packed = run(folder.path(), "config.xml --hematocrit 0.2");
  INFO(packed.all());
  CHECK(packed.exitCode == 0);
  CHECK_THAT(packed.err, Contains("mended 1 triangle without area") && Contains("inside out"));
  // HemoCell deflates this one: a node fewer along each axis than of the sound tube.
  CHECK_THAT(packed.out, Contains("of 50 x 32 x 32"));
  CHECK(run(folder.path(), "check config.xml").exitCode == 0);
}

TEST_CASE("an STL that had to be repaired is a warning for HemoCell, too", "[executable]") {
  const SampleCase folder;
  std::string stl = tubeStl(2.4, 0.75, 48);
  CHECK(run(folder.path(), "config.xml --rbc 3").err.empty());
  const std::size_t facet = stl.find("vertex"), next = stl.find("vertex", facet + 1),
                    last = stl.find("vertex", next + 1);
  const std::string first = stl.substr(facet, next - facet), second = stl.substr(next, last - next);
  stl.replace(facet, last - facet, second + first);
  writeText(folder.path() / "tube.stl", stl);
  const Ran ran = run(folder.path(), "config.xml --rbc 3");
  INFO(ran.all());
  CHECK(ran.exitCode == 0);
  CHECK_THAT(ran.err, Contains("turned round 1 triangle") && Contains("HemoCell reads the file as it is"));

  writeText(folder.path() / "tube.stl", tubeStl(-2.4, 0.75, 48));  // mirrored: inside out
  const Ran mirrored = run(folder.path(), "config.xml --rbc 3");
  INFO(mirrored.all());
  CHECK(mirrored.exitCode == 0);
  CHECK_THAT(mirrored.err, Contains("turned 1 surface that was inside out") &&
                               Contains("HemoCell reads the file as it is"));
  CHECK(run(folder.path(), "check config.xml").exitCode == 0);
}

TEST_CASE("a mesh or an ellipsoid on the command line replaces that of the file", "[executable]") {
  const SampleCase folder(
      "<packing> <species name=\"egg\" count=\"2\" file=\"tube.stl\" scale=\"4\"/> </packing>");
  CHECK_THAT(run(folder.path(), "config.xml").out, Contains("egg: 2 (2 asked for), tube.stl"));
  const Ran ran = run(folder.path(), "config.xml --cell egg 3 4 5 6");
  INFO(ran.all());
  CHECK(ran.exitCode == 0);
  CHECK_THAT(ran.out, Contains("egg: 3 (3 asked for), ellipsoid"));
}

TEST_CASE("nearness to the limit is one of meshes, whatever a red cell counts as", "[executable]") {
  const TemporaryFolder folder;
  const Ran packCells = run(folder.path(), "20 20 20 --hematocrit 0.61 --plt_ratio 0", "packCells");
  INFO(packCells.all());
  CHECK(packCells.exitCode == 0);  // 0.51 by mesh
  CHECK_THAT(packCells.err, !Contains("of the lumen: above"));
  const Ran counted = run(folder.path(), "15 15 15 --rbc 26 --max-iterations 1 --best-effort");
  INFO(counted.all());
  CHECK_THAT(counted.err, Contains("fill 0.6249 of the lumen: above 0.61"));
}

TEST_CASE("a ratio that looks like per cent is told", "[executable]") {
  const TemporaryFolder folder;
  const Ran ran = run(folder.path(), "20 20 20 --hematocrit 0.02 --plt_ratio 7 --dry-run");
  CHECK(ran.exitCode == 0);
  CHECK_THAT(ran.err, Contains("a ratio of 7 is 7 PLT for each red cell, not per cent; 0.07 may be meant"));
  CHECK(run(folder.path(), "20 20 20 --hematocrit 0.2 --plt_ratio 1 --dry-run").err.empty());
  const SampleCase file(
      "<packing> <hematocrit> 0.1 </hematocrit> <species name=\"RBC\"/> <species name=\"PLT\" ratio=\"5\"/> "
      "</packing>");
  CHECK_THAT(run(file.path(), "config.xml --dry-run").err, Contains("0.05 may be meant"));
}

TEST_CASE("check says what it could not examine", "[executable]") {
  const SampleCase folder;
  writeText(folder.path() / "RBC.pos", rbcPos("8 8 8 0 0 0\n", 1));
  CHECK_THAT(run(folder.path(), "check config.xml").out, Contains("Verdict: clean\n"));
  writeText(folder.path() / "ghost.pos", rbcPos("8 8 8 0 0 0\n", 1));
  const Ran ran = run(folder.path(), "check config.xml");
  CHECK(ran.exitCode == 0);
  CHECK_THAT(ran.out, Contains("Verdict: clean; not examined: ghost.pos\n"));
}

TEST_CASE("out of reach: says how far it came, writes only on request, keeps old files", "[executable]") {
  const TemporaryFolder folder;
  writeText(folder.path() / "RBC.pos", "old");
  const std::string arguments = "15 15 15 --hematocrit 0.72 --plt_ratio 0 --max-iterations 300 --max-time 20";
  Ran ran = run(folder.path(), arguments);
  INFO(ran.all());
  CHECK(ran.exitCode == 3);
  CHECK_THAT(ran.err, Contains("the densest certified packing found has hematocrit"));
  CHECK_THAT(ran.err, Contains("near") || Contains("above 0.61"));
  CHECK(readText(folder.path() / "RBC.pos") == "old");
  ran = run(folder.path(), arguments + " --best-effort");
  INFO(ran.all());
  CHECK(ran.exitCode == 0);
  CHECK(cellsIn(folder.path() / "RBC.pos") > 0);
  CHECK(run(folder.path(), "check --box 15 15 15").exitCode == 0);
}

TEST_CASE("a limit that is met with nothing left to do is no failure", "[executable]") {
  const TemporaryFolder folder;
  for (const char* arguments :
       {"60 60 60 --rbc 5 --max-iterations 1", "60 60 60 --rbc 1 --ends periodic --max-time 1e-9"}) {
    const Ran ran = run(folder.path(), arguments);
    INFO(arguments << "\n" << ran.all());
    CHECK(ran.exitCode == 0);
  }
  // With more to do than there is time for, no density is called the largest.
  const Ran late = run(folder.path(), "40 40 40 --hematocrit 0.5 --max-time 1e-9");
  INFO(late.all());
  CHECK(late.exitCode == 3);
  CHECK_THAT(late.err,
             Contains("a certified packing found has hematocrit") && !Contains("the densest certified"));
}

TEST_CASE("check does not look at all pairs where all cells overlap", "[executable]") {
  const TemporaryFolder folder;
  std::string file = "1000\n";
  for (int cell = 0; cell < 1000; ++cell) file += fmt::format("{}e-6 1e-6 2e-6 0 0 0\n", cell % 20);
  writeText(folder.path() / "RBC.pos", file);
  const Ran ran = run(folder.path(), "check 20 20 20");
  INFO(ran.all());
  CHECK(ran.exitCode == int(ExitCode::faultsFound));
  CHECK_THAT(ran.out,
             Contains("Overlapping pairs: at least 100") && Contains("further pairs were not examined"));
}

TEST_CASE("Ctrl-C ends cleanly", "[executable]") {
  const TemporaryFolder folder;
  // A shell's background jobs ignore SIGINT, python's do not; the signal comes when the run has told what it
  // packs.
  const TemporaryFolder scripts;
  writeText(scripts.path() / "interrupt.py", R"(import signal, subprocess, sys
run = subprocess.Popen(sys.argv[1:], stdout=subprocess.PIPE)
run.stdout.readline()
run.send_signal(signal.SIGINT)
run.communicate()
sys.exit(run.returncode)
)");
  const Ran ran = run(folder.path(), "40 40 40 --hematocrit 0.65", "packMesh",
                      "python3 '" + (scripts.path() / "interrupt.py").string() + "'");
  INFO(ran.all());
  CHECK(ran.exitCode == 130);
  CHECK_THAT(ran.err, Contains("interrupted: nothing was written"));
  CHECK(fs::is_empty(folder.path()));
}

TEST_CASE("help, reference and version", "[executable]") {
  const TemporaryFolder folder;
  Ran ran = run(folder.path(), "--help");
  CHECK(ran.exitCode == 0);
  CHECK_THAT(ran.out, Contains("--hematocrit"));
  CHECK(run(folder.path(), "--help", "packCells").exitCode == 0);
  CHECK(run(folder.path(), "--reference").exitCode == 0);
  CHECK_THAT(run(folder.path(), "--version").out, Contains("packMesh "));
  CHECK(fs::is_empty(folder.path()));
}
