// SPDX-License-Identifier: AGPL-3.0-or-later
// The files of config/ that users copy.

#include "hemocell_adapter/base/xml_tags.h"
#include "hemocell_adapter/hemocell/cell_model.h"
#include "hemocell_adapter/settings/packing_section.h"
#include "packMesh/packing/packing_problem.h"
#include "tests/support/catch.h"
#include "tests/support/places.h"

using namespace packmesh;
using namespace packmesh::hemocell;

TEST_CASE("config/<Cell>.xml contains HemoCell's default parameters", "[config]") {
  const std::string name = GENERATE("RBC", "RBC_m", "PLT", "PLT_m", "PLT_mko", "WBC");
  INFO(name);
  const CellModel model = readCellXml(std::string(test::sourceFolder) + "/config/" + name + ".xml", name);
  const auto expected = defaultModel(name);
  REQUIRE(expected);
  CHECK(model.name == name);
  CHECK(model.construction == expected->construction);
  CHECK(model.radius == Approx(expected->radius).epsilon(1e-12));
  CHECK(model.minNumTriangles == expected->minNumTriangles);
  CHECK(model.aspectRatio == Approx(expected->aspectRatio).epsilon(1e-12));
}

TEST_CASE("config/packing.xml is a <packing> section with the defaults it states", "[config]") {
  const std::string file = std::string(test::sourceFolder) + "/config/packing.xml";
  tinyxml2::XMLDocument document;
  REQUIRE(document.LoadFile(file.c_str()) == tinyxml2::XML_SUCCESS);
  REQUIRE(document.RootElement()->Name() == std::string("packing"));
  const Request settings = readPackingSection(*document.RootElement(), file);
  CHECK(settings.hematocrit == 0.40);
  REQUIRE(settings.species.size() == 2);
  CHECK(settings.species[0].name == "RBC");
  CHECK(settings.species[1].name == "PLT");
  CHECK(settings.species[1].ratio == 0.07);
  const PackingProblem defaults;
  CHECK_FALSE(settings.states("clearance"));  // gaps as wide as possible
  CHECK_FALSE(settings.states("wallClearance"));
  CHECK(settings.seed == defaults.physics.seed);
  CHECK(settings.periodicEnds == false);
  CHECK(settings.bestEffort == false);
}
