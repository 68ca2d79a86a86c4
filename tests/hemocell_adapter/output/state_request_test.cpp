// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/state_request.h"

#include <catch2/catch.hpp>

#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/settings/command_line.h"
#include "hemocell_adapter/settings/request_json.h"
#include "packMesh/core/error.h"
#include "packMesh/packing/state_cells.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/places.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

TEST_CASE("Files in the folder of a state are found where the state is") {
  const Request request =
      parseCommandLine("packMesh", {"/a & b/run/config.xml", "--start=/a & b/run/in/RBC.pos", "--fixed",
                                    "/a & b/runs/PLT.pos", "--report", "/x/a & b/run/y.json", "--restart",
                                    "/a & b/run/state.h5", "--blood", "/a & b/run/caf\xe9.h5"})
          .request;
  const StateRecord record = recordOf(request, "/a & b/other/../run/state.h5");
  CHECK_THAT(record.request, Contains(R"("config":{"beside":"config.xml"})") &&
                                 Contains(R"("/a & b/runs/PLT.pos")") && !Contains("restart"));
  Request same = requestIn(record, "/a & b/run/state.h5");
  CHECK(same.config == "/a & b/run/config.xml");
  CHECK(findSpecies(same, "RBC")->start->string() == "/a & b/run/in/RBC.pos");
  CHECK(same.blood->string() == "/a & b/run/caf\xe9.h5");
  CHECK(same.output.reportFile == "/x/a & b/run/y.json");
  CHECK(same.originOf("report")->kind == Origin::Kind::state);
  const Request moved = requestIn(record, "/new/s.h5");
  CHECK(moved.config == "/new/config.xml");
  CHECK(findSpecies(moved, "PLT")->fixed->string() == "/a & b/runs/PLT.pos");
}

TEST_CASE("Numbers that were given are in the record of a state") {
  const auto given =
      std::make_shared<Given>(Given{"vessel", heading("vessel"), {{"vertices", 3, {0, 0, 1, 2, 3, 4}}}});
  Request request;
  request.container.emplace().lumen.emplace().kind = SolidRequest::Kind::mesh;
  request.container->lumen->file = Source(std::shared_ptr<const Given>(given));
  const StateRecord record = recordOf(request, "s.h5");
  const Request again = requestIn(record, "s.h5");
  REQUIRE(again.container->lumen->file.given);
  CHECK(again.container->lumen->file.given->find("vertices")->values == given->tables[0].values);
  CHECK(recordOf(overridden(again, request), "s.h5").inputs.size() == 1);
}

TEST_CASE("A state without a request is not continued") {
  CHECK_THROWS_WITH(requestIn({"", {}, "iteration 3"}, "s.h5"), Contains("has the cells of a simulation"));
  CHECK_THROWS_WITH(requestIn({}, "s.h5"), Contains("earlier version"));
  CHECK_THROWS_WITH(requestIn({"{", {}, ""}, "s.h5"), Contains("not JSON"));
  CHECK_THROWS_WITH(requestIn({"{\"sed\": 1}", {}, ""}, "s.h5"), Contains("s.h5: sed: is no setting"));
}

TEST_CASE("The cells of a state of version 2 are read, and its run is not continued", "[executable]") {
  const TemporaryFolder folder;
  const fs::path state = folder.path() / "two.h5";
  fs::copy(fs::path(test::sourceFolder) / "tests/data/state_version_2.h5", state);
  const StateCells cells = readStateCells(state, Communicator());
  CHECK(cells.cells.size() == 2);
  CHECK(cells.species.at(0).name == "PLT");
  CHECK(cells.certified);
  CHECK_THROWS_WITH(readStateHead(state), Contains("version 2") && Contains("reads version 3"));
  ok(folder, "10 10 10 --plt 3 --ends periodic --start two.h5");
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
  CHECK_THAT(state, Contains("{\"beside\":\"config.xml\"}"));
  CHECK(state.find(test::programFolder) == std::string::npos);
  CHECK(state.find(case_.string()) == std::string::npos);
  fs::remove(case_ / "RBC.pos");
  fs::rename(case_, folder.path() / "moved");
  ok(folder, "--restart moved/s.h5");
  CHECK(readText(folder.path() / "moved/RBC.pos") == before);
}
