// SPDX-License-Identifier: AGPL-3.0-or-later
// Soft cells, with the real executable.
#include <catch2/catch.hpp>

#include "tests/hemocell_adapter/sample_case.h"

using namespace packmesh;
using namespace packmesh::test;
using Catch::Matchers::Contains;

TEST_CASE("Soft cells fill a box beyond what undeformed ones can, and are saved as a state", "[executable]") {
  const TemporaryFolder folder;
  const Ran ran = ok(folder, "14 14 14 --ends periodic --hematocrit 0.75 --soft --state s.h5");
  CHECK_THAT(ran.out, Contains("Soft cells: 27 deformed; largest force on a vertex"));
  CHECK_THAT(ok(folder, "check --box 14 14 14 --ends periodic --start s.h5").out, Contains("RBC: 25 cells"));
}

TEST_CASE("Soft cells fold in a capillary", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "--cylinder x 2.8 30 --ends periodic --rbc 2 --soft --state s.h5");
  CHECK_THAT(ok(folder, "check --cylinder x 2.8 30 --ends periodic --start s.h5").out,
             Contains("RBC: 2 cells"));
}

TEST_CASE("Cells that need not deform are those of a packing without --soft", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "16 16 16 --ends periodic --hematocrit 0.3 --soft");
  const std::string soft = readText(folder.path() / "RBC.pos");
  ok(folder, "16 16 16 --ends periodic --hematocrit 0.3");
  CHECK(readText(folder.path() / "RBC.pos") == soft);
}

TEST_CASE("The largest force refuses soft cells", "[executable]") {
  const TemporaryFolder folder;
  const Ran ran =
      run(folder.path(),
          "14 14 14 --ends periodic --hematocrit 0.75 --soft --max-force 0.05 --max-time 20 --state s.h5");
  CHECK(ran.exitCode == 3);
  CHECK_THAT(ran.err, Contains("at most 0.05 pN") && Contains("--max-force"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "s.h5"));
}
