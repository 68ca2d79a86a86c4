// SPDX-License-Identifier: AGPL-3.0-or-later
// A box repeated, with the real executable.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/hemocell/read_pos.h"
#include "tests/hemocell_adapter/sample_case.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
using Catch::Matchers::Contains;

TEST_CASE("Columns are repeated, and the state of the result is that of the large box", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "16 18 20 --ends periodic --rbc 12 --order columns --tile 2 1 1 --state s.h5");
  CHECK(readPos(folder.path() / "RBC.pos").size() == 24);
  CHECK_THAT(ok(folder, "check --box 32 18 20 --ends periodic --start s.h5").out, Contains("RBC: 24 cells"));
}

TEST_CASE("A repeated box keeps its hematocrit", "[executable]") {
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
