// SPDX-License-Identifier: AGPL-3.0-or-later
// packMesh check, with the real executable.
#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "hemocell_adapter/base/exit_codes.h"
#include "tests/hemocell_adapter/sample_case.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
using Catch::Matchers::Contains;

TEST_CASE("check tests the requested clearances", "[executable]") {
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

TEST_CASE("check reports what it could not examine", "[executable]") {
  const SampleCase folder;
  writeText(folder.path() / "RBC.pos", rbcPos("8 8 8 0 0 0\n", 1));
  CHECK_THAT(run(folder.path(), "check config.xml").out, Contains("Verdict: clean\n"));
  writeText(folder.path() / "ghost.pos", rbcPos("8 8 8 0 0 0\n", 1));
  const Ran ran = run(folder.path(), "check config.xml");
  CHECK(ran.exitCode == 0);
  CHECK_THAT(ran.out, Contains("Verdict: clean; not examined: ghost.pos\n"));
}

TEST_CASE("check stops searching for overlaps when all cells overlap", "[executable]") {
  const TemporaryFolder folder;
  std::string file = "1000\n";
  for (int cell = 0; cell < 1000; ++cell) file += fmt::format("{}e-6 1e-6 2e-6 0 0 0\n", cell % 20);
  writeText(folder.path() / "RBC.pos", file);
  const Ran ran = run(folder.path(), "check 20 20 20");
  INFO(ran.all());
  CHECK(ran.exitCode == int(ExitCode::faultsFound));
  CHECK_THAT(ran.out, Contains("Overlapping pairs: at least 100") &&
                          Contains("further pairs were not examined") &&
                          Contains("; of those found, 0 are among cells HemoCell keeps\n"));
}

TEST_CASE("check rejects options of packing", "[executable]") {
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
