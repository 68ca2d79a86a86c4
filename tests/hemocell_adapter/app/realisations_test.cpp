// SPDX-License-Identifier: AGPL-3.0-or-later
// Several packings in one run, with the real executable.
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh::test;
namespace fs = std::filesystem;

TEST_CASE("Realisations differ by their seeds and have separate folders", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "15 15 15 --hematocrit 0.2 --plt_ratio 0 --seed 7 --output-dir alone");
  ok(folder, "15 15 15 --hematocrit 0.2 --plt_ratio 0 --seed 6 --realisations 10");
  std::set<std::string> texts;
  for (const char* i : {"01", "02", "03", "04", "05", "06", "07", "08", "09", "10"})
    texts.insert(readText(folder / (std::string("realisation_") + i) / "RBC.pos"));
  CHECK(texts.size() == 10);
  CHECK(readText(folder / "realisation_02/RBC.pos") == readText(folder / "alone/RBC.pos"));
  const Ran failed = ended(folder, 3, "15 15 15 --hematocrit 0.7 --max-iterations 5 --realisations 2");
  CHECK_THAT(failed.err, Contains("realisations that failed: 1, 2"));
}

TEST_CASE("The reports of realisations name their neighbours", "[executable]") {
  const TemporaryFolder folder;
  CHECK_THAT(ok(folder, "15 15 15 --rbc 2 --realisations 10 --report r.json").out,
             Contains("To compare them: packmesh compare ./realisation_*/r.json --page compare.html"));
  const auto realisation = [&](const char* path) { return readJson(folder / path)["realisation"]; };
  CHECK(realisation("realisation_01/r.json") ==
        nlohmann::json{{"number", 1}, {"of", 10}, {"previous", nullptr}, {"next", "realisation_02"}});
  CHECK(realisation("realisation_09/r.json")["next"] == "realisation_10");
  CHECK(realisation("realisation_10/r.json")["next"].is_null());
  CHECK(realisation("realisation_10/r.json")["previous"] == "realisation_09");
  ok(folder, "15 15 15 --rbc 2 --report r.json");
  CHECK(realisation("r.json").is_null());
}

TEST_CASE("A realisation continues from the files of its own folder", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "15 15 15 --rbc 3 --realisations 2 --state s.h5 --report r.json");
  const fs::path one = folder / "realisation_2";
  const std::string before = readText(one / "RBC.pos");
  fs::remove(one / "RBC.pos");
  fs::remove(one / "r.json");
  ok(folder, "--restart realisation_2/s.h5");
  CHECK(readText(one / "RBC.pos") == before);
  CHECK(fs::exists(one / "r.json"));
  CHECK_FALSE(fs::exists(folder / "r.json"));
  CHECK_FALSE(fs::exists(folder / "s.h5"));
}

TEST_CASE("A restart continues the remaining realisations from any working directory", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "15 15 15 --rbc 3 --realisations 3 --state s.h5");
  std::map<std::string, std::string> before;
  for (const char* i : {"1", "2", "3"})
    before[i] = readText(folder / (std::string("realisation_") + i) / "RBC.pos");
  for (const bool inside : {false, true}) {
    CAPTURE(inside);
    for (const char* i : {"2", "3"}) fs::remove(folder / (std::string("realisation_") + i) / "RBC.pos");
    const Ran ran = inside ? run(folder / "realisation_2", "--restart s.h5")
                           : run(folder, "--restart realisation_2/s.h5");
    INFO(ran.all());
    CHECK(ran.exitCode == 0);
    CHECK_THAT(ran.out, !Contains("Realisation 1 of 3") && Contains("Realisation 2 of 3: seed 2") &&
                            Contains("Realisation 3 of 3: seed 3") && Contains("Of 3 realisations:") &&
                            Contains("Realisations: 3 of 3 written"));
    for (const auto& [i, text] : before) CHECK(readText(folder / ("realisation_" + i) / "RBC.pos") == text);
    CHECK_FALSE(fs::exists(folder / "realisation_2/realisation_2"));
    CHECK_FALSE(fs::exists(folder / "realisation_2/realisation_1"));
  }
  const std::string table = readText(folder / "realisations.csv");
  CHECK(std::count(table.begin(), table.end(), '\n') == 4);
  fs::rename(folder / "realisation_2/s.h5", folder / "s.h5");
  CHECK_THAT(ended(folder, 1, "--restart s.h5").err, Contains("./realisation_1/state.h5; found 's.h5'"));
}

TEST_CASE("Realisations of a case continue in their folders, and check examines all of them",
          "[executable][long]") {
  const SampleCase folder(
      "<packing> <species name=\"RBC\" count=\"3\"/> <realisations> 2 </realisations> </packing>");
  ok(folder, "config.xml --state s.h5");
  const std::string before = readText(folder / "realisation_2/RBC.pos");
  fs::remove_all(folder / "realisation_2");
  ok(folder / "realisation_1", "--restart s.h5");
  CHECK(readText(folder / "realisation_2/RBC.pos") == before);
  ok(folder.path().parent_path(), "--restart '" + (folder / "realisation_1/s.h5").string() + "'");

  Ran checked = ok(folder, "check config.xml");
  CHECK_THAT(checked.out, Contains("realisation_1: clean; 3 cells") &&
                              Contains("realisation_2: clean; 3 cells") &&
                              Contains("HemoCell keeps 3 of 3") && Contains("Verdict: 2 of 2 folders clean"));
  // A cell twice, and files beside the realisations.
  writeText(folder / "realisation_2/RBC.pos", "2\n12 8 8 0 0 0\n12 8 8 0 0 0\n");
  writeText(folder / "RBC.pos", before);
  checked = ended(folder, 4, "check config.xml");
  CHECK_THAT(checked.out, Contains("realisation_1: clean") &&
                              Contains("realisation_2: not clean; 2 cells, hematocrit") &&
                              Contains("1 overlapping pairs") && Contains("HemoCell keeps 3 of 3 RBC") &&
                              Contains("Verdict: 2 of 3 folders clean"));
  CHECK(ok(folder, "check config.xml --output-dir realisation_1").out.find("Verdict: clean") !=
        std::string::npos);
  writeText(folder / "realisation_1/RBC.pos", "none\n");
  checked = ended(folder, 4, "check config.xml");
  CHECK_THAT(checked.out, Contains("realisation_1: not examined") && Contains("1 of 3 folders clean"));
  CHECK_THAT(checked.err, Contains("realisation_1/RBC.pos:1"));
  CHECK_THAT(ok(folder, "config.xml").err, Contains("RBC.pos belongs to none of the realisations"));
}

TEST_CASE("Means and standard deviations of realisations are printed and written", "[executable]") {
  const TemporaryFolder folder;
  CHECK_THAT(ok(folder, "18 18 18 --hematocrit 0.4 --plt_ratio 0 --realisations 3 --seed 5").out,
             Contains("Of 3 realisations:") && Contains("std. dev.") &&
                 Contains("  hematocrit of the lumen") && Contains("  minimum gap [µm]") &&
                 Contains("  minimum gap to the wall [µm]") && Contains("  sweeps") &&
                 Contains("  CPU time [s]"));
  std::istringstream rows(readText(folder / "realisations.csv"));
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
  CHECK_THAT(readText(folder / "realisations.csv"), Contains("1,1,bestEffort,"));
  ended(folder, 3, "15 15 15 --hematocrit 0.7 --max-iterations 1 --realisations 2");
  CHECK_THAT(readText(folder / "realisations.csv"), Contains("2,2,failed,,,,,,,"));
}
