// SPDX-License-Identifier: AGPL-3.0-or-later
// The species to pack, of requests.

#include "hemocell_adapter/problem/species_plans.h"
#include "hemocell_adapter/settings/command_line.h"
#include "hemocell_adapter/settings/packing_section.h"
#include "hemocell_adapter/settings/request_json.h"
#include "packMesh/core/error.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;

namespace {

std::vector<std::string> toldOfSpecies;

SpeciesToPack chosenSpecies(const std::vector<std::string>& words) {
  toldOfSpecies.clear();
  return chooseSpecies(parseCommandLine("packMesh", words).request, nullptr, toldOfSpecies);
}

std::vector<std::string> namesOfChosen(const SpeciesToPack& of) {
  std::vector<std::string> names;
  for (const SpeciesRequest& species : of.species) names.push_back(species.name);
  return names;
}

using NamesOfSpecies = std::vector<std::string>;

}  // namespace

TEST_CASE("A hematocrit adds red cells and platelets to the species that are stated", "[species]") {
  const SpeciesToPack all = chosenSpecies({"30", "30", "30", "--hematocrit", "0.3", "--wbc", "2"});
  CHECK(namesOfChosen(all) == NamesOfSpecies{"RBC", "PLT", "WBC"});
  CHECK_FALSE(all.species[0].count);
  CHECK(all.species[1].ratio == packCellsPlateletRatio);
  CHECK(all.species[2].count == 2);
  CHECK(all.hematocrit == 0.3);
  CHECK(namesOfChosen(chosenSpecies({"30", "30", "30", "--hematocrit", "0.3", "--plt_ratio", "0"})) ==
        NamesOfSpecies{"RBC"});
  CHECK(namesOfChosen(chosenSpecies({"30", "30", "30", "--wbc", "2"})) == NamesOfSpecies{"WBC"});
}

TEST_CASE("Details of cells are of those that a hematocrit adds, and of no others", "[species]") {
  const SpeciesToPack all = chosenSpecies({"30", "30", "30", "--hematocrit", "0.3", "--rigid", "PLT"});
  REQUIRE(namesOfChosen(all) == NamesOfSpecies{"RBC", "PLT"});
  CHECK(all.species[1].rigid);
  CHECK_THROWS_WITH(chosenSpecies({"30", "30", "30", "--rbc", "3", "--rigid", "WBC"}),
                    Contains("settings for 'WBC', but there are no such cells to pack"));
}

TEST_CASE("A red species of <packing> stays one of them when an option says more about it", "[species]") {
  tinyxml2::XMLDocument section;
  section.Parse(
      "<packing><hematocrit>0.3</hematocrit><species name='RBC'/><species name='RBC_b' "
      "count='3'/></packing>");
  const Request listed = readPackingSection(*section.RootElement(), "config.xml");
  for (const std::string option : {"", "RBC", "RBC_b"}) {
    CAPTURE(option);
    std::vector<std::string> words = {"30", "30", "30"}, told;
    if (!option.empty()) words.insert(words.end(), {"--rigid", option});
    const Request asked = overridden(listed, parseCommandLine("packMesh", words).request);
    const SpeciesToPack chosen = chooseSpecies(asked, nullptr, told);
    CHECK(namesOfChosen(chosen) == NamesOfSpecies{"RBC", "RBC_b"});
    CHECK(chosen.hematocrit == 0.3);
    CHECK_FALSE(chosen.species.front().count);
  }
  section.RootElement()->FirstChildElement("species")->SetAttribute("name", "RCB");
  const Request misspelled = readPackingSection(*section.RootElement(), "config.xml");
  std::vector<std::string> told;
  CHECK_THROWS_WITH(chooseSpecies(misspelled, nullptr, told),
                    Contains("for every red cell (did you mean 'RBC'?); remove one of them"));
}

TEST_CASE("The request from which species are chosen is as it was", "[species]") {
  Request request;
  request.boxSize = Vec3(30, 30, 30);
  request.hematocrit = 0.2;
  std::vector<std::string> ignored;
  const SpeciesToPack all = chooseSpecies(request, nullptr, ignored);
  CHECK(all.species.size() == 2);
  CHECK(request.species.empty());
  CHECK(speciesWithStates(request).species.empty());
}

TEST_CASE("A ratio of platelets without a hematocrit is told", "[species]") {
  chosenSpecies({"30", "30", "30", "--rbc", "3", "--plt_ratio", "0.1"});
  REQUIRE(toldOfSpecies.size() == 1);
  CHECK_THAT(toldOfSpecies.front(), Contains("is ignored"));
}
