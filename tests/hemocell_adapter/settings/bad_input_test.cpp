// SPDX-License-Identifier: AGPL-3.0-or-later
// What users get wrong: what is refused in this process, the rest with the real executable.
#include <functional>

#include "tests/hemocell_adapter/refusal.h"
#include "tests/support/catch.h"

using namespace packmesh::test;
namespace fs = std::filesystem;

namespace {

/// The sample's tube with a point of its rim pulled across to beyond the opposite side.
std::string spikedTubeStl() {
  std::string stl = tubeStl(2.4, 0.75, 48);
  const std::string from = "2.3999999999999999 0.75 0\n", to = "2.3999999999999999 -3 0\n";
  for (std::size_t at = stl.find(from); at != stl.npos; at = stl.find(from, at))
    stl.replace(at, from.size(), to);
  return stl;
}

}  // namespace

TEST_CASE("Invalid input is explained, and nothing is written", "[executable]") {
  const auto config = [](const std::string& domain, const std::string& packing = "") {
    return [=](const fs::path& folder) { writeText(folder / "config.xml", configXml(domain, packing)); };
  };
  const auto file = [](const std::string& name, const std::string& text) {
    return [=](const fs::path& folder) { writeText(folder / name, text); };
  };
  const std::string h = "config.xml --hematocrit 0.2",
                    soft = "10 10 10 --ends periodic --hematocrit 0.73 --soft ";
  const std::vector<RefusedRow> rows = {
      {"", 1, "nothing to do"},
      {"50 50 50 --hematocrti 0.3", 1, "did you mean '--hematocrit'?"},
      {"50 50 50", 1, "how many cells?"},
      {"0 50 50 --rbc 1", 1, "size sX: expected a number in (0, 100000] [µm], found '0'"},
      {"-50 50 50 --rbc 1", 1, "found '-50'"},
      {"nan 50 50 --rbc 1", 1, "expected"},
      {"1e9 50 50 --rbc 1", 1, "found '1e9'"},
      {"50 50 50 --rbc 0", 2, "nothing to pack"},
      {"50 50 50 --rbc 99999999 --wbc 2", 2, "100000001 cells are too many; at most 100000000 can be packed"},
      {"50 50 50 --rbc 1 --seed -1", 1, "expected a whole number in [0, 9223372036854775807], found '-1'"},
      {"--vessel tube.stl 1e6 --rbc 1", 2, "tube.stl: with the factor 1e+06 it reaches 2.4e+06 µm"},
      {"50 50 50 --hematocrit 1.2", 1, "[0, 1)"},
      {"50 50 50 --hematocrit 1e-9", 2, "nothing to pack"},
      {"5 5 2 --rbc 1", 2, "larger than the lumen"},
      {"50 50 50 --rbc 1 --output-dir RBC.xml", 5, "is not a folder"},
      {"50 50 50 --rbc 1 --output-dir /proc/none", 5, ""},
      {"15 15 15 --hematocrit 0.72 --max-iterations 50 --output-dir sub", 5, "PLT.pos: is not a regular file",
       [](const fs::path& folder) { fs::create_directories(folder / "sub/PLT.pos"); }},
      {"50 50 50 --rbc 1 --minimum-distance-from-solid RBC 1", 1, "requires a case"},
      {"config.xml --rbc 1 --minimum-distance-from-solid WBC 1", 1, "no such cells"},
      {"config.xml --rbc 1 --minimum-distance-from-solid RBC 50", 2, "would delete every such cell"},
      {"50 50 50 --rbc 1 --nor", 1, "did you mean '--noRotate'?"},
      {"--cylinder x 10 20 --sphere 10 --rbc 1", 1, "--cylinder excludes --sphere"},
      {"50 50 50 --cell-mesh big 2 tube.stl --mesh-scale big 10000", 2, "larger than the lumen"},
      {"50 50 50 --rbc 60 --clearance 20", 2, "60 cells 20 µm apart need a lumen larger than"},
      {"config.xml --rbc 9 --clearance 50", 2, "9 cells 50 µm apart need a lumen larger than"},
      {"50 50 50 --rbc 1 --noRotate --orient RBC 0 0 1 20", 2, "keeps every orientation at 0 0 0"},
      {"15 15 15 --rbc 1 --walls z --cell-free-layer 2 --fixed near/RBC.pos", 2, "which stays where it is, ",
       [](const fs::path& folder) {
         fs::create_directories(folder / "near");
         writeText(folder / "near/RBC.pos", rbcPos("7 7 2.5 90 0 0\n", 1));
       }},
      {"50 50 50 --cell-mesh egg 2 tube.stl --cell egg 3 3 4 5", 1,
       "option '--cell': cell 'egg' is already described by '--cell-mesh'"},
      {"50 50 50 --cell big 2 30000 30000 30000", 2, "larger than the lumen"},
      {"1e-9 20 20 --cell a 1 1e-10 1 1", 2, "the box is 1e-09 µm along x, less than the lattice spacing"},
      {"1e-9 20 20 --ends periodic --cell a 1 1e-10 1 1", 2,
       "the period of the lumen, 1e-09 µm along x, is too small for the certificate"},
      {"check --box 1e-9 20 20 --ends periodic", 2,
       "is too large or too far away for a lumen with a period of 1e-09 µm",
       file("RBC.pos", "1\n4 4 4 0 0 0\n")},
      {"20 20 20 --rbc 1 --report k.html --state k.html", 5, "k.html: two outputs have this name"},
      {"20 20 20 --rbc 1 --report RBC.json --state ./RBC.json", 5, "two outputs have this name"},
      {"20 20 20 --rbc 1 --vtp --state RBC.vtp", 5, "two outputs have this name"},
      {"20 20 20 --rbc 1 --export csv --state cells.csv", 5, "two outputs have this name"},
      {h, 2, "config.xml:6: <growth>: it is for <method> cat",
       config(sampleDomain, "<packing><growth alpha=\"0.1\"/></packing>")},
      {h, 2, "<clearance>: expected a number in [0, 100]",
       config(sampleDomain, "<packing><clearance>0.2<b>0.9</b></clearance></packing>")},
      {"nowhere.xml --rbc 1", 2, "no such file"},
      {". --rbc 1", 2, "is a folder"},
      {h, 2, "config.xml:1: is not well-formed XML: text outside of any tag", file("config.xml", "hello")},
      {h, 2, "config.xml:1: is not well-formed XML: an element is not closed",
       file("config.xml", "<hemocell>")},
      {h, 2, "expected the root <hemocell>", file("config.xml", "<vessel/>")},
      {h, 2, "<dx>: expected", config("<dx> half </dx>")},
      {h, 2, "unknown tag in <packing>; did you mean 'clearance'?",
       config(sampleDomain, "<packing><clearence>1</clearence></packing>")},
      {h, 2, "<packing>: unknown attribute 'ends'; write it as a tag inside: <ends> periodic </ends>",
       config(sampleDomain, "<packing ends=\"periodic\"/>")},
      {h, 2, "<packing>: unknown attribute 'sead'; did you mean 'seed'?",
       config(sampleDomain, "<packing sead=\"2\"/>")},
      {h, 2, "<seed>: unknown attribute 'value'; expected <seed> 2 </seed>",
       config(sampleDomain, "<packing><seed value=\"2\"/></packing>")},
      {h, 2, "<container>: unknown attribute 'size'; expected <box>",
       config(sampleDomain, "<packing><container size=\"2\"/></packing>")},
      {h, 2, "<container>: stray text 'box'",
       config(sampleDomain, "<packing><container>box</container></packing>")},
      {h, 2, "config.xml:4: <geometry>: tube.stl: <refDirN> 30000 along y gives a lattice of more",
       config("<geometry> tube.stl </geometry> <dx> 5e-7 </dx> <refDir> 1 </refDir> <refDirN> 30000 "
              "</refDirN>")},
      {h, 2, "describe such a lumen", [](const fs::path& folder) { fs::remove(folder / "tube.stl"); }},
      {h, 2, "tube.stl", file("tube.stl", "")},
      {h, 2, "tube.stl", file("tube.stl", "not an STL at all")},
      {h, 2, "found '?[2J?'", file("tube.stl", "solid a\n\x1b[2J\x07\n" + std::string(100, ' '))},
      {h, 2, "expected a binary STL file of 684 bytes for the 12 triangles",
       file("tube.stl",
            "solid" + std::string(75, ' ') + std::string("\x0c\0\0\0", 4) + std::string(550, 'x'))},
      {h + " --flat-openings refuse --validate", 2, "not closed: it has 3 open edges",
       file("tube.stl", tubeStl(2.4, 0.75, 48, true))},
      {h + " --flat-openings maybe", 1, "expected cap or refuse"},
      {h, 2, "tube.stl: the surface intersects itself",
       [](const fs::path& folder) {
         writeText(folder / "tube.stl", spikedTubeStl());
         writeText(folder / "config.xml",
                   configXml("<dx>5e-7</dx><nx>40</nx><ny>40</ny><nz>40</nz>",
                             "<packing><walls>xyz</walls><region hematocrit=\"0.1\"><mesh file=\"tube.stl\" "
                             "scale=\"4\"/></region></packing>"));
       }},
      {h, 2, "tube.stl: all triangles of the mesh are collapsed", file("tube.stl", tubeStl(0, 0, 48))},
      {h + " --ends periodic", 2, "<geometry>: tube.stl: the two ends",
       file("tube.stl", tubeStl(2.4, 0.75, 48, false, 1.1))},
      {h, 2, "RBC.xml", [](const fs::path& folder) { fs::remove(folder / "RBC.xml"); }},
      {h, 2, "RBC.xml", file("RBC.xml", cellXml("RBC", -1, 600, ""))},
      {"config.xml --rbc 1", 2, "larger than the lumen", file("RBC.xml", cellXml("RBC", 39, 600, ""))},
      {"config.xml", 1, "how many cells?"},
      {"config.xml --wbc 2", 2, "WBC.xml"},
      {"config.xml --hematocrit 0.2 --plt_ratio 0.1", 2, "PLT.xml",
       [](const fs::path& folder) { fs::remove(folder / "PLT.xml"); }},
      {h, 2, "specify it by --walls", config("<dx>5e-7</dx><nx>40</nx><ny>40</ny><nz>40</nz>")},
      {h + " --walls yz", 1, "option '--walls': walls are chosen for boxes only"},
      {h, 2, "config.xml:6: <walls>: walls are",
       config(sampleDomain, "<packing><walls>yz</walls></packing>")},
      {h, 2, "config.xml: how many 'PLT'?",
       config(sampleDomain, "<packing><species name=\"PLT\"/></packing>")},
      {h, 2, "config.xml: <container> has no body", config(sampleDomain, "<packing><container/></packing>")},
      {h, 2, "the lumen reaches from y = -8 to 8 µm, the lattice only from -0.25 to",
       config(sampleDomain,
              "<packing><container><cylinder radius=\"8\" length=\"20\" center=\"10 0 "
              "8\"/></container></packing>")},
      {h, 2, "<preInlet>",
       file("config.xml", "<hemocell><domain>" + sampleDomain + "</domain><preInlet/></hemocell>")},
      {h + " --wall-clearance 7.5", 2, "less the clearance of 7.5 µm to the wall"},
      {h + " --cell-mesh RBC 5 tube.stl", 2, "the number of 'RBC' follows from the hematocrit"},
      {"config.xml --rbc 2 --wbc 2", 2,
       "WBC.xml: no such file; it must define how HemoCell builds the cell 'WBC'"},
      {"20 20 20 --rbc 12 --clearance max --state s.h5", 1, "--clearance max"},
      {"15 15 15 --rbc 2 --realisations 0", 1, "'--realisations'"},
      {"30 30 30 --cell Rod 1 60 2 2", 2, "larger than the lumen"},
      {"20 20 20 --hematocrit 0", 2, "asks for no red cells; use it with regions"},
      {"config.xml --hematocrit 0.3 --plt 3 --validate", 1, "--plt"},
      // A box that is repeated
      {"16 18 20 --ends periodic --rbc 3 --walls x --tile 2 1 1", 2, "the box is not periodic along x"},
      {"16 18 20 --ends periodic --rbc 3 --tile 0 2 1", 1, "'--tile'"},
      {"16 18 20 --ends periodic --rbc 3 --tile 10000 10000 1", 2, "the box would be more than 100000 µm"},
      // Soft cells
      {soft + "--clearance max", 1, "--soft and --"},
      {soft + "--order columns", 1, "--soft and --"},
      {"10 10 10 --rbc 3 --soft --also-dx 0.25", 1, "--soft and --"},
      {soft + "--method cat", 1, "--soft"},
      {"check", 1, "nothing to check"},
      {"check --box 16 16 16 --dry-run", 1, "is for packing, not for check"},
      {"check --box 16 16 16 --validate", 1, "is for packing, not for check"},
      {"check --box 16 16 16 --realisations 2", 1, "is for packing, not for check"},
      {"check --box 16 16 16 --tile 1 2 1", 1, "is for packing, not for check"},
      {"check --box 16 16 16 --state s.h5", 1, "is for packing, not for check"},
      {"check --box 16 16 16 --restart s.h5", 1, "is for packing, not for check"},
      {"check --box 16 16 16 --checkpoint-every 3", 1, "is for packing, not for check"},
      {"check --box config.xml", 1,
       "check --box needs three sizes: check --box sX sY sZ; found 'config.xml'"},
      {"check config.xml", 2, "no .pos files"},
      {"check config.xml", 2, "nothing to check: egg.pos is not checked: there is no egg.xml",
       file("egg.pos", rbcPos("1 2 3 0 0 0\n", 1))},
      {"check config.xml", 2, "no .pos files to check; RBC.POS must be named RBC.pos, as HemoCell reads it",
       file("RBC.POS", rbcPos("1 2 3 0 0 0\n", 1))},
      {"check config.xml", 2, "cells.pos is of an old version of HemoCell",
       file("cells.pos", rbcPos("1 2 3 0 0 0\n", 1))},
      {"check config.xml", 2, "RBC.pos:1", file("RBC.pos", rbcPos("1 2 3 0 0 0\n", 2))},
      {"check config.xml", 2, "RBC.pos:2", file("RBC.pos", rbcPos("1 2 3 0 0\n", 1))},
      {"check config.xml", 2, "RBC.pos:2", file("RBC.pos", rbcPos("1 2 3 0 0 0 7\n", 1))},
      {"check config.xml", 2, "RBC.pos:2", file("RBC.pos", rbcPos("# x y z a b c\n1 2 3 0 0 0\n", 1))},
      {"check config.xml", 2, "RBC.pos:2", file("RBC.pos", rbcPos("1 2 nan 0 0 0\n", 1))},
      {"check config.xml", 2, "RBC.pos:1", file("RBC.pos", "many\n1 2 3 0 0 0\n")},
      {"check config.xml", 2, "RBC.pos", file("RBC.pos", "")},
      {"check --box 20 20 20", 2, "RBC.pos:2: field 1 (x): expected a number between -100000 and 100000",
       file("RBC.pos", rbcPos("1e20 8 8 0 0 0\n", 1))},
  };
  requireRefused(rows);
}

TEST_CASE("What cannot be packed or is not clean has exit codes of its own", "[executable]") {
  const auto pos = [](const std::string& lines, int count) {
    return [=](const fs::path& folder) { writeText(folder / "RBC.pos", rbcPos(lines, count)); };
  };
  const std::vector<RefusedRow> rows = {
      {"50 50 50 --rbc 99999999", 3, "the lumen only"},
      {"--sphere 3.8 --rbc 1 --max-iterations 20", 3, "not even one cell could be packed"},
      {"5 5 5 --rbc 1", 3, "not even one cell could be packed"},
      {"5 5 5 --rbc 1 --ends periodic --max-iterations 2000", 3, "not even one cell could be packed"},
      {"15 15 15 --hematocrit 0.72 --plt_ratio 0 --max-iterations 30", 3, "limits: 30 sweeps; "},
      {"check config.xml", 4, "not clean", pos("8 8 8 0 0 0\n8.5 8 8 0 0 0\n", 2)},
      {"check config.xml", 4, "deletes 1", pos("500 8 8 0 0 0\n", 1)},
  };
  for (const RefusedRow& row : rows) {
    const SampleCase folder;
    row.spoil(folder.path());
    const int before = folder.files();
    const Ran ran = run(folder, row.arguments);
    INFO("packMesh " << row.arguments << "\n" << ran.all());
    CHECK(ran.exitCode == row.exitCode);
    CHECK_THAT(ran.all(), Contains(row.message));
    CHECK(Catch::contains(ran.err, "(packMesh) (Error) ") == (row.exitCode == 3));
    CHECK(folder.files() == before);
  }
}
