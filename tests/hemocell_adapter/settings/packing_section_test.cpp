// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/packing_section.h"

#include "packMesh/core/error.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;

namespace {

Request section(const std::string& text) {
  tinyxml2::XMLDocument document;
  REQUIRE(document.Parse(text.c_str()) == tinyxml2::XML_SUCCESS);
  return readPackingSection(*document.RootElement(), "folder/config.xml");
}

}  // namespace

TEST_CASE("Paths in a packing section are relative to its file, and places name tag and line", "[settings]") {
  const Request request = section(
      "<packing>\n<species name=\"RBC\" file=\"a.stl\"/><start>b.h5</start>\n<fixed>PLT.pos</fixed>"
      "<profile>developed</profile><stateFile>s.h5</stateFile>"
      "<region hematocrit=\"0.4\"><mesh file=\"c.stl\"/></region></packing>");
  CHECK(request.species[0].meshFile == Source("folder/a.stl"));
  CHECK(request.startStates[0] == Source("folder/b.h5"));
  CHECK(request.species[1].fixed == Source("folder/PLT.pos"));
  CHECK(request.profile == Source("developed"));
  CHECK(request.output.stateFile == "folder/s.h5");
  CHECK(request.regions[0].body.file == Source("folder/c.stl"));
  CHECK(request.originOf("species.RBC.file")->place == "folder/config.xml:2: <species>, attribute file");
  CHECK(request.originOf("profile")->place == "folder/config.xml:3: <profile>");
}

TEST_CASE("Errors in a packing section state where they are", "[settings]") {
  CHECK_THROWS_WITH(section("<packing>\n<species name=\"RBC\" count=\"-1\"/></packing>"),
                    Contains("folder/config.xml:2: <species>, attribute count: "));
  CHECK_THROWS_WITH(section("<packing><species name=\"RBC\" count=\"1\" ratio=\"1\"/></packing>"),
                    Contains("both a count and a ratio"));
  CHECK_THROWS_WITH(section("<packing><sed>1</sed></packing>"), Contains("config.xml:1: <sed>: unknown tag"));
}
