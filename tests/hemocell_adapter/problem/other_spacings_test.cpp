// SPDX-License-Identifier: AGPL-3.0-or-later
// One packing that HemoCell keeps at several lattice spacings, by the model of its loader.
#include <filesystem>

#include "hemocell_adapter/hemocell/pos_file.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
namespace fs = std::filesystem;

namespace {

/// A case at a lattice spacing: `<domain>` with as many nodes as the extent needs.
struct Sized {
  const char* name;
  const char* packing;
  std::string (*domain)(double dx);
};

std::string spacing(double dx) {
  return "<dx> " + std::to_string(dx) + "e-6 </dx> ";
}

std::string nodes(const char* tag, double length, double dx) {
  return std::string("<") + tag + "> " + std::to_string(int(std::lround(length / dx))) + " </" + tag + "> ";
}

const Sized cases[] = {
    {"tube", "",
     [](double dx) {
       return "<geometry> tube.stl </geometry> <refDir> 1 </refDir>" + spacing(dx) + nodes("refDirN", 15, dx);
     }},
    {"plates", "<walls> yz </walls>",
     [](double dx) { return spacing(dx) + nodes("nx", 24, dx) + nodes("ny", 16, dx) + nodes("nz", 17, dx); }},
    {"cylinder in a box",
     "<container> <cylinder axis=\"x\" radius=\"7\" length=\"24\" center=\"12 8 8\"/> </container>",
     [](double dx) { return spacing(dx) + nodes("nx", 24, dx) + nodes("ny", 16, dx) + nodes("nz", 16, dx); }},
    {"obstacle",
     "<walls> z </walls> <container> <obstacles> <sphere radius=\"3\" center=\"12 8 8\"/> </obstacles> "
     "</container>",
     [](double dx) { return spacing(dx) + nodes("nx", 30, dx) + nodes("ny", 20, dx) + nodes("nz", 16, dx); }},
};

/// The same case at another spacing, with .pos files of a folder.
Ran checkedAt(double dx, const Sized& one, const fs::path& posFiles) {
  SampleCase folder;
  writeText(folder / "config.xml",
            configXml(one.domain(dx), std::string("<packing> ") + one.packing + " </packing>"));
  for (const char* name : {"RBC.pos", "PLT.pos"}) writeText(folder / name, readText(posFiles / name));
  return run(folder, "check config.xml");
}

}  // namespace

TEST_CASE("Cells are kept at every spacing, in each kind of lumen", "[executable][alsodx][long]") {
  for (const Sized& one : cases)
    for (const char* seed : {"1", "2"}) {
      CAPTURE(one.name, seed);
      SampleCase folder;
      writeText(
          folder / "config.xml",
          configXml(one.domain(0.5), std::string("<packing> <hematocrit> 0.3 </hematocrit> <alsoDx> 0.25 1 "
                                                 "</alsoDx> <species name=\"RBC\"/> <species name=\"PLT\" "
                                                 "ratio=\"0.3\"/> ") +
                                         one.packing + " </packing>"));
      CHECK_THAT(ok(folder, std::string("config.xml --seed ") + seed).out,
                 Contains("Also at dx 0.25 µm") && Contains("Also at dx 1 µm"));
      CHECK_THAT(ok(folder, "check config.xml").out, Contains("Verdict: clean"));
      for (const auto& [dx, name] :
           {std::pair(0.5, ""), std::pair(0.25, "dx_0.25"), std::pair(1.0, "dx_1")}) {
        CAPTURE(dx);
        const bool framed = one.name == std::string("tube") && dx != 0.5;
        CHECK(fs::exists(folder / name / "RBC.pos") == (framed || dx == 0.5));
        const Ran checked = checkedAt(dx, one, framed ? folder / name : folder.path());
        INFO(checked.all());
        CHECK_THAT(checked.out, Contains("Verdict: clean"));
      }
    }
}

TEST_CASE("Without the other spacings, cells are lost there", "[executable][alsodx]") {
  const Sized& one = cases[1];
  SampleCase folder;
  writeText(folder / "config.xml",
            configXml(one.domain(0.25),
                      std::string("<packing> <hematocrit> 0.3 </hematocrit> <wallClearance> 0 "
                                  "</wallClearance> <species name=\"RBC\"/> <species name=\"PLT\" "
                                  "ratio=\"0.3\"/> ") +
                          one.packing + " </packing>"));
  ok(folder, "config.xml");
  CHECK(checkedAt(1.0, one, folder.path()).exitCode != 0);
  CHECK_THAT(run(folder, "check config.xml --also-dx 1").out, Contains("at dx 1 µm"));
}

TEST_CASE("A box from the command line is what is kept at every spacing", "[executable][alsodx]") {
  TemporaryFolder folder;
  CHECK_THAT(ok(folder, "25 20 20 --hematocrit 0.3 --also-dx 0.25 1").out,
             Contains("only what HemoCell keeps at dx 1 µm, too"));
  for (const char* dx : {"0.25", "0.5", "1"})
    CHECK_THAT(ok(folder, std::string("check --box 25 20 20 --dx ") + dx).out, Contains("Verdict: clean"));
}

TEST_CASE("Other spacings that make no sense are refused", "[executable][alsodx]") {
  SampleCase folder;
  struct Row {
    const char* arguments;
    int code;
    const char* message;
  };
  for (const Row& row :
       {Row{"config.xml --hematocrit 0.2 --also-dx 0.4", 2, "--also-dx 0.4: <refDirN> 30 at dx 0.5"},
        Row{"config.xml --hematocrit 0.2 --also-dx 1e-9", 2, "--also-dx 1e-09: <refDirN> 30 would be"},
        Row{"25 20 20 --hematocrit 0.2 --also-dx 1e-9", 2, "--also-dx 1e-09: "},
        Row{"25 20 20 --hematocrit 0.2 --also-dx 21", 2, "--also-dx 21: "},
        Row{"config.xml --hematocrit 0.2 --also-dx 0", 1, "'--also-dx'"},
        Row{"config.xml --hematocrit 0.2 --also-dx 0.25 x", 1, ""},
        Row{"config.xml --hematocrit 0.2 --ends periodic --also-dx 0.25", 2, "closed ends"},
        Row{"--cylinder x 8 20 --hematocrit 0.2 --also-dx 0.25", 2, "cases and boxes with closed ends"}}) {
    CAPTURE(row.arguments);
    CHECK_THAT(ended(folder, row.code, row.arguments).err, Contains(row.message));
  }
}
