// SPDX-License-Identifier: AGPL-3.0-or-later
// Packings in memory against what the executable writes. Python's side of it: tests/python.
#include "hemocell_adapter/session/in_memory.h"

#include <nlohmann/json.hpp>
#include <sstream>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/outputs.h"
#include "hemocell_adapter/settings/command_line.h"
#include "packMesh/core/error.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

namespace {

/// @param last one more word, which may have blanks
Packing packed(const std::string& words, const Hooks& hooks = {}, const std::string& last = "") {
  std::istringstream in(words);
  std::vector<std::string> all;
  for (std::string word; in >> word;) all.push_back(word);
  if (!last.empty()) all.push_back(last);
  log::setLevel(log::Level::silent);
  const auto restore = [] { log::setLevel(log::Level::normal); };
  try {
    Packing packing = packInMemory(parseCommandLine("packMesh", all).request, Communicator(), hooks);
    restore();
    return packing;
  } catch (...) {
    restore();
    throw;
  }
}

}  // namespace

TEST_CASE("A packing in memory is that of the program", "[held]") {
  const TemporaryFolder folder;
  const std::string words = GENERATE(as<std::string>(), "16 16 16 --rbc 6 --plt 2 --seed 3",
                                     "12 12 12 --rbc 6 --ends periodic --tile 2 1 1");
  ok(folder, words + " --report report.json");
  const Packing packing = packed(words);
  const std::vector<StateCells::Kind> kinds = kindsOf(packing);
  REQUIRE(folder.files() == (kinds.size() == 2 ? 3 : 2));
  writeCells(packing, folder / "held", {});
  for (const StateCells::Kind& kind : kinds)
    CHECK(readText(folder / "held" / (kind.name + ".pos")) == readText(folder / (kind.name + ".pos")));
  auto expected = readJson(folder / "report.json");
  auto report = parseJson(reportText(packing));
  for (const char* run : {"times", "command", "configuration", "program"})
    for (nlohmann::json* one : {&expected, &report}) one->erase(run);
  CHECK(report == expected);
}

TEST_CASE("A packing that was saved is loaded with the same cells, and completed by its command", "[held]") {
  const TemporaryFolder folder;
  const Packing packing = packed("16 16 16 --rbc 6 --plt 2");
  const std::filesystem::path file = folder / "cells.h5";
  savePacking(packing, file);
  const StateCells cells = loadCells(file, Communicator(), file);
  REQUIRE(cells.species.size() == 2);
  CHECK(cells.species[0].count == 6);
  REQUIRE(requestOfCells(cells, file));
  const Packing loaded = completePacking(cells, file, Communicator());
  CHECK(formatPosLines(posLinesOf(packing)) == formatPosLines(posLinesOf(loaded)));
  CHECK(loaded.certificate.clean());
  CHECK(loaded.tally.redMesh == packing.tally.redMesh);
  CHECK(loaded.kept.kept == packing.kept.kept);
  const StateCells gathered = gatherCells(cellsOf(loaded, cells.species), Communicator());
  REQUIRE(gathered.cells.size() == cells.cells.size());
  for (std::size_t i = 0; i < cells.cells.size(); ++i) {
    CHECK(gathered.cells[i].species == cells.cells[i].species);
    CHECK(gathered.cells[i].pose.position == cells.cells[i].pose.position);
  }
}

TEST_CASE("A state has the placements that were certified, to the last bit", "[held]") {
  const TemporaryFolder folder;
  writeText(folder / "RBC.pos",
            rbcPos("8 8 8 10.1 20.7 33.3\n8 8 20 -71.3 12.9 0.7\n8 20 8 3.1 -50.3 99.9\n", 3));
  const std::string words =
      GENERATE(as<std::string>(), "10 10 10 --ends periodic --hematocrit 0.73 --plt_ratio 0 --soft", "fixed");
  const Packing packing = words == "fixed"
                              ? packed("30 30 30 --rbc 3 --fixed", {}, (folder / "RBC.pos").string())
                              : packed(words);
  const std::filesystem::path file = folder / "cells.h5";
  savePacking(packing, file);
  const StateCells cells = loadCells(file, Communicator(), file);
  const Packing loaded = completePacking(cells, file, Communicator());
  REQUIRE(cells.cells.size() == packing.cells.size());
  REQUIRE(loaded.cells.size() == packing.cells.size());
  for (std::size_t i = 0; i < packing.cells.size(); ++i) {
    const Placement& certified = packing.cells[i].placement;
    for (const Placement& other : {placementOf(lineOf(cells.cells[i])), loaded.cells[i].placement}) {
      CHECK(other.linear == certified.linear);
      CHECK(other.translation == certified.translation);
    }
    if (words != "fixed")
      CHECK(cells.cells[i].vertices == packing.problem->shapes[packing.cells[i].shape]->mesh().vertices);
  }
  CHECK(formatPosLines(posLinesOf(packing)) == formatPosLines(posLinesOf(loaded)));
  CHECK(loaded.certificate.minimumGap == packing.certificate.minimumGap);
}

TEST_CASE("Hooks interrupt a packing in memory, and nothing is written", "[held]") {
  const TemporaryFolder folder;
  int told = 0;
  Hooks hooks;
  hooks.progress = [&](const Progress&, ProgressLog& log) {
    ++told;
    CHECK_FALSE(log.remaining(0.5));  // it has just begun
  };
  hooks.interrupted = [&] { return told >= 3; };
  try {
    packed("25 25 25 --hematocrit 0.64 --ends periodic", hooks);
    FAIL("not interrupted");
  } catch (const AgreedFailure& failure) {
    CHECK(failure.code() == ExitCode::interrupted);
    CHECK(failure.what() == std::string("interrupted: nothing was written"));
  }
  CHECK(told >= 3);
  CHECK_THROWS_AS(packed("20 20 20 --hematocrit 2"), InputError);
}
