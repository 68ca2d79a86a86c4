// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/xdmf.h"

#include <tinyxml2.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <set>
#include <sstream>

#include "packMesh/core/error.h"
#include "packMesh/io/hdf5_reader.h"
#include "packMesh/packing/state_file.h"
#include "tests/support/packings.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;
namespace fs = std::filesystem;

namespace {

struct Item {
  std::string path;
  std::array<std::int64_t, 2> size;
};

/// All tables that a companion names, by the name of what has them.
std::vector<std::pair<std::string, Item>> itemsOf(const tinyxml2::XMLElement& element) {
  std::vector<std::pair<std::string, Item>> items;
  for (const auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
    if (std::string(child->Name()) != "DataItem") {
      for (auto& item : itemsOf(*child)) items.push_back(item);
      continue;
    }
    const char* name = element.Attribute("Name");
    const std::string text = child->GetText();
    Item item{text.substr(text.find(':') + 1), {0, 1}};
    REQUIRE(text.substr(0, text.find(':')) == "my state.h5");
    std::istringstream(child->Attribute("Dimensions")) >> item.size[0] >> item.size[1];
    items.emplace_back(name ? name : element.Name(), item);
  }
  return items;
}

}  // namespace

TEST_CASE("The companion of a state names every table with its size, and each mesh once") {
  const test::TemporaryFolder folder;
  const fs::path state = folder.path() / "my state.h5", xdmf = folder.path() / "my state.xdmf";
  PackingProblem problem = test::mixtureIn(test::periodicCube(25.0), 0.4, 3);
  problem.physics.species[1].name = "A < B & \"C\"";
  PackingState last;
  problem.checkpoints = Checkpoints{{}, [&](const PackingState& s) { last = s; }};
  REQUIRE(pack(problem).outcome == Outcome::certified);
  writeState(state, problem, {}, last);
  writeXdmf(xdmf, state, last.cellCount, problem.physics.species);

  tinyxml2::XMLDocument document;
  REQUIRE(document.LoadFile(xdmf.c_str()) == tinyxml2::XML_SUCCESS);
  const Hdf5Reader tables(state);
  std::set<std::string> names, paths;
  for (const auto& [name, item] : itemsOf(*document.RootElement())) {
    INFO(item.path);
    std::array<std::int64_t, 2> size = tables.size(item.path);
    REQUIRE(item.size == size);
    REQUIRE(paths.insert(item.path).second);
    names.insert(name);
  }
  REQUIRE(names == std::set<std::string>{"Geometry", "Topology", "id", "species", "orientation", "scale",
                                         "overlap", "gap", "local_hematocrit"});
  std::set<std::string> grids;
  const auto* domain = document.RootElement()->FirstChildElement("Domain");
  for (const auto* grid = domain->FirstChildElement(); grid; grid = grid->NextSiblingElement())
    grids.insert(grid->Attribute("Name"));
  REQUIRE(grids == std::set<std::string>{"cells", "RBC_mesh", "A < B & \"C\"_mesh"});
}

TEST_CASE("The last state of a run contains measurements, and earlier ones state that there are none") {
  const test::TemporaryFolder folder;
  PackingProblem problem = test::mixtureIn(test::periodicCube(25.0), 0.4, 3);
  std::vector<PackingState> states;
  problem.checkpoints = Checkpoints{[] { return true; }, [&](const PackingState& s) { states.push_back(s); }};
  REQUIRE(pack(problem).outcome == Outcome::certified);
  REQUIRE(states.size() > 2);
  const auto gapsIn = [&](const PackingState& state) {
    writeState(folder.path() / "state.h5", problem, {}, state);
    return Hdf5Reader(folder.path() / "state.h5").table<double>("/cells/gap", 1);
  };
  for (const double gap : gapsIn(states.front())) REQUIRE(std::isnan(gap));
  for (const double gap : gapsIn(states.back())) {
    REQUIRE(gap > 0.0);
    REQUIRE(gap <= 1.0);
  }
  double mean = 0.0;
  for (const double local : states.back().measures.localHematocrit) {
    REQUIRE(local > 0.0);
    REQUIRE(local < 1.0);
    mean += local / double(states.back().measures.localHematocrit.size());
  }
  REQUIRE(mean == Approx(0.4).margin(0.04));
}

TEST_CASE("A companion that cannot be written is an error that names it") {
  REQUIRE_THROWS_AS(writeXdmf("/no such folder/state.xdmf", "state.h5", 1, {}), OutputError);
}
