// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/state_words.h"

#include <catch2/catch.hpp>

#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/places.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;
using Words = std::vector<std::string>;

TEST_CASE("Files in the folder of a state are found where the state is") {
  const Words words = {"packMesh",
                       "/a & b/run/config.xml",
                       "--start=/a & b/run/in/RBC.pos",
                       "--fixed",
                       "/a & b/runs/PLT.pos",
                       "relative/x",
                       "--report",
                       "/x/a & b/run/y",
                       "",
                       "<packing><species name='S' file=\"/a &amp; b/run/s.off\"/></packing>"};
  const Words stored = storedWords(words, "/a & b/other/../run/state.h5");
  CHECK(stored == Words{"packMesh", "{folder}/config.xml", "--start={folder}/in/RBC.pos", "--fixed",
                        "/a & b/runs/PLT.pos", "relative/x", "--report", "/x/a & b/run/y", "",
                        "<packing><species name='S' file=\"{folder}/s.off\"/></packing>"});
  CHECK(wordsNow(stored, "/a & b/run/state.h5") == words);
  CHECK(wordsNow(stored, "/new'/s.h5").back() ==
        "<packing><species name='S' file=\"/new&apos;/s.off\"/></packing>");
  CHECK(storedWords({"/config.xml"}, "/state.h5") == Words{"{folder}/config.xml"});
}

TEST_CASE("A state is continued after its folder was moved, and names no place of the program",
          "[executable]") {
  const TemporaryFolder folder;
  const fs::path case_ = folder.path() / "case";
  fs::create_directory(case_);
  {
    const SampleCase sample;
    fs::copy(sample.path(), case_, fs::copy_options::recursive);
  }
  ok(folder, "'" + (case_ / "config.xml").string() + "' --hematocrit 0.1 --state '" +
                 (case_ / "s.h5").string() + "'");
  const std::string before = readText(case_ / "RBC.pos");
  const std::string state = readText(case_ / "s.h5");
  CHECK_THAT(state, Contains("{folder}/config.xml"));
  CHECK(state.find(test::programFolder) == std::string::npos);
  CHECK(state.find(case_.string()) == std::string::npos);
  fs::remove(case_ / "RBC.pos");
  fs::rename(case_, folder.path() / "moved");
  ok(folder, "--restart moved/s.h5");
  CHECK(readText(folder.path() / "moved/RBC.pos") == before);
}
