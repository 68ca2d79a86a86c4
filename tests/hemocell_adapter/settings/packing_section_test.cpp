// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/packing_section.h"

#include <catch2/catch.hpp>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/problem/completed_request.h"
#include "packMesh/core/error.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using Catch::Matchers::Contains;

TEST_CASE("A packing section adds to settings that are known, or changes them", "[settings]") {
  const Request known =
      withPackingSection({},
                         "<packing><seed>7</seed><species name=\"RBC\" file=\"a.stl\"/>"
                         "<species name=\"PLT\" ratio=\"0.1\" wallClearance=\"0.3\"/>"
                         "<region hematocrit=\"0.4\"><sphere radius=\"3\"/></region></packing>",
                         "first");
  const Request changed =
      withPackingSection(known,
                         "<packing><species name=\"PLT\" count=\"5\"/><species name=\"WBC\" count=\"1\"/>"
                         "<region hematocrit=\"0.2\"><box size=\"1 2 3\"/></region></packing>",
                         "second");
  CHECK(changed.seed == 7);
  REQUIRE(changed.species.size() == 3);
  CHECK(changed.species[0].meshFile == "a.stl");
  CHECK(changed.species[1].count == 5);
  CHECK_FALSE(changed.species[1].ratio);
  CHECK(changed.species[1].wallClearance == 0.3);
  REQUIRE(changed.regions.size() == 1);
  CHECK(changed.regions[0].hematocrit == 0.2);
  CHECK(withPackingSection(known, "<packing/>", "third").regions.size() == 1);
}

TEST_CASE("Errors in a packing section state where it comes from", "[settings]") {
  const auto wrong = [](const char* text) { return withPackingSection({}, text, "settings"); };
  CHECK_THROWS_WITH(wrong("<packing>\n<species name=\"RBC\" count=\"-1\"/></packing>"),
                    Contains("settings:2: <species>, attribute count: "));
  CHECK_THROWS_WITH(wrong("<packing><species name=\"RBC\" count=\"1\" ratio=\"1\"/></packing>"),
                    Contains("both a count and a ratio"));
  CHECK_THROWS_WITH(wrong("<hemocell/>"), Contains("settings: expected a section <packing>"));
  CHECK_THROWS_AS(wrong("<packing>"), InputError);
}

TEST_CASE("A packing section can be a word of the command line", "[settings]") {
  const auto request = [](const std::string& section) {
    return requestToPack(parseCommandLine("packMesh", {"20", "20", "20", section, "--seed", "3"})).request;
  };
  const Request regions = request(
      "<packing><hematocrit>0.1</hematocrit><seed>9</seed>"
      "<region hematocrit=\"0.2\"><sphere radius=\"3\"/></region></packing>");
  CHECK(regions.regions.size() == 1);
  CHECK(regions.hematocrit == 0.1);
  CHECK(regions.seed == 3);
  CHECK(regions.boxSize == Vec3(20, 20, 20));
  CHECK_THROWS_WITH(request("<packing><hematocrit>0.1</hematocrit><escape>true</escape></packing>"),
                    Contains("argument: <escape>: it is for <method> cat"));
  CHECK_THROWS_WITH(request("<packing><sed>1</sed></packing>"), Contains("argument:1: <sed>: unknown tag"));
  CHECK_THROWS_AS(parseCommandLine("packMesh", {"<packing/>", "<packing/>", "20", "20", "20"}), UsageError);
}
