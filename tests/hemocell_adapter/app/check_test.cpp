// SPDX-License-Identifier: AGPL-3.0-or-later
// packMesh check, with the real executable.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "hemocell_adapter/base/exit_codes.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
namespace fs = std::filesystem;

TEST_CASE("check tests the requested clearances", "[executable]") {
  const TemporaryFolder folder;
  const std::string tube = "--cylinder x 8 30 ";
  ok(folder, tube + "--rbc 9 --clearance 0.2 --wall-clearance 0.3");
  for (const auto& [asked, exitCode] :
       std::vector<std::pair<std::string, ExitCode>>{{"", ExitCode::ok},
                                                     {"--clearance 0.2 --wall-clearance 0.3", ExitCode::ok},
                                                     {"--clearance 8", ExitCode::faultsFound},
                                                     {"--wall-clearance 6", ExitCode::faultsFound},
                                                     {"--cell-free-layer 6", ExitCode::faultsFound}}) {
    const Ran ran = run(folder, "check " + tube + asked);
    INFO(asked + "\n" + ran.all());
    CHECK(ran.exitCode == int(exitCode));
  }
  CHECK_THAT(run(folder, "check " + tube + "--clearance 8").out,
             Contains("Overlapping pairs or nearer than 8 µm: ") && Contains(" µm apart\n") &&
                 Contains("Minimum gap: ") && !Contains("cells overlap"));
}

TEST_CASE("check reports what it could not examine", "[executable]") {
  const SampleCase folder;
  writeText(folder / "RBC.pos", rbcPos("8 8 8 0 0 0\n", 1));
  CHECK_THAT(run(folder, "check config.xml").out, Contains("Verdict: clean\n"));
  writeText(folder / "ghost.pos", rbcPos("8 8 8 0 0 0\n", 1));
  CHECK_THAT(ok(folder, "check config.xml").out, Contains("Verdict: clean; not examined: ghost.pos\n"));
}

TEST_CASE("check numbers cells as packing does", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "20 20 20 --rbc 2 --plt 2 --export csv");
  const std::string packed = readText(folder / "cells.csv");
  ok(folder, "check --box 20 20 20 --export csv");
  const auto order = [](const std::string& text) { return text.find("RBC") < text.find("PLT"); };
  CHECK(order(packed));
  CHECK(order(readText(folder / "cells.csv")));
}

TEST_CASE("check stops searching for overlaps when all cells overlap", "[executable][long]") {
  const TemporaryFolder folder;
  std::string file = "1000\n";
  for (int cell = 0; cell < 1000; ++cell) file += fmt::format("{}e-6 1e-6 2e-6 0 0 0\n", cell % 20);
  writeText(folder / "RBC.pos", file);
  CHECK_THAT(ended(folder, int(ExitCode::faultsFound), "check 20 20 20").out,
             Contains("Overlapping pairs: at least 100000\n") &&
                 Contains("further pairs were not examined") && Contains("RBC.pos:2 and RBC.pos:3") &&
                 Contains("Verdict: not clean"));
}

TEST_CASE("check of many lines that are the same ends after a bounded number of pairs", "[executable]") {
  const TemporaryFolder folder;
  constexpr int cells = 30000;
  std::string file = fmt::format("{}\n", cells);
  for (int cell = 0; cell < cells; ++cell) file += "10 10 10 0 0 0\n";
  writeText(folder / "RBC.pos", file);
  const Ran ran = run(folder, "check 20 20 20 --verbose");
  INFO(ran.all().substr(0, 5000));
  CHECK(ran.exitCode == int(ExitCode::faultsFound));
  CHECK_THAT(ran.out,
             Contains("Overlapping pairs: at least 120000\n") && Contains("RBC.pos:2 and RBC.pos:3"));
  std::size_t listed = 0;
  for (std::size_t at = 0; (at = ran.out.find("the meshes meet", at)) != std::string::npos; ++at) ++listed;
  CHECK(listed >= 5);
  CHECK(listed < 50);
}

TEST_CASE("check writes the same outputs of files as the run that packed them", "[executable][long]") {
  const SampleCase folder;
  const std::string outputs =
      " --report out/report.html --pov --vtp --vtp-meshes --export csv --export lammps";
  ok(folder, "config.xml --hematocrit 0.2 --plt_ratio 0.2 --export csv --vtp" + outputs);
  const std::string pos = readText(folder / "RBC.pos");
  const nlohmann::json packed = readJson(folder / "out/report.json");
  const std::vector<std::string> names = {"cells.csv",    "cells.lammps",  "lumen.vtp",      "RBC.vtp",
                                          "RBC_mesh.vtp", "RBC_cells.vtp", "out/report.html"};
  for (const std::string& name : names) fs::remove(folder / name);
  const Ran ran = ok(folder, "check config.xml" + outputs);
  for (const std::string& name : names) {
    CAPTURE(name);
    CHECK(fs::exists(folder / name));
    CHECK_THAT(ran.out, Contains("Wrote ") && Contains(name));
  }
  CHECK(readText(folder / "RBC.pos") == pos);
  const nlohmann::json checked = readJson(folder / "out/report.json");
  CHECK(checked["outcome"] == "checked");
  CHECK(checked["hematocrit"][0] == packed["hematocrit"][0]);
  CHECK(checked["certificate"]["minimumGap"] == packed["certificate"]["minimumGap"]);
  CHECK(checked["hemocell"] == packed["hemocell"]);
  for (const auto& one : checked["species"]) {
    CHECK(one["request"] == "in the file");
    CHECK(one["asked"] == one["placed"]);
  }
}

TEST_CASE("check reports files with violations", "[executable]") {
  const TemporaryFolder folder;
  writeText(folder / "RBC.pos", rbcPos("8 8 8 0 0 0\n9 8 8 0 0 0\n90000 8 8 0 0 0\n", 3));
  ended(folder, int(ExitCode::faultsFound), "check 20 20 20 --ends closed --walls xyz --report r.html --vtp");
  const nlohmann::json report = readJson(folder / "r.json");
  CHECK(report["certificate"]["overlapping"] == 1);
  CHECK(report["certificate"]["clean"] == false);
  CHECK_THAT(readText(folder / "r.html"), Contains("\"overlapping\":[[0,1]]"));
  CHECK(fs::exists(folder / "RBC.vtp"));
}

TEST_CASE("check of a state names the state, and no .pos files", "[executable]") {
  const TemporaryFolder folder;
  CHECK_THAT(ok(folder, "20 20 20 --rbc 5 --cell Rod 2 4 2 2 --state s.h5").out,
             Contains("Wrote s.h5 (7 cells; load it by packmesh::loadParticles(hemocell, \"s.h5\"))"));
  const Ran small = run(folder, "check --box 2 2 2 --start s.h5");
  INFO(small.all());
  CHECK(small.exitCode != 0);
  CHECK_THAT(small.all(),
             Contains("s.h5: RBC 1 is outside the lumen") && !Contains(".pos is") && !Contains("RBC.pos"));
  CHECK_THAT(small.all(), Contains("Rod of s.h5 is not checked: its shape is unknown"));
}

TEST_CASE("check writes no outputs that only the configuration requests", "[executable]") {
  const SampleCase folder("<packing> <report> report.html </report> <vtp> true </vtp> </packing>");
  writeText(folder / "RBC.pos", rbcPos("8 8 8 0 0 0\n", 1));
  ok(folder, "check config.xml");
  CHECK_FALSE(fs::exists(folder / "report.html"));
  CHECK_FALSE(fs::exists(folder / "RBC.vtp"));
}

TEST_CASE("check reports on one folder, not on realisations", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "20 20 20 --rbc 1 --realisations 2");
  CHECK_THAT(ended(folder, 1, "check 20 20 20 --report r.html").err, Contains("--output-dir"));
  ok(folder, "check 20 20 20 --report r.html --output-dir realisation_2");
}
