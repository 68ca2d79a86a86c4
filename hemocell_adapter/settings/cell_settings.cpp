// SPDX-License-Identifier: AGPL-3.0-or-later
// Request of the cells.
#include "hemocell_adapter/settings/setting_groups.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

using namespace specs;

/// The request for the species that the file is named after.
SpeciesRequest& cellsInFile(Request& settings, const std::string& file) {
  try {
    return speciesNamed(settings, text(parseValue(name(), std::filesystem::path(file).stem().string())));
  } catch (const InputError& error) {
    throw InputError(file + ": the name before .pos is the name of the cells; " + error.what());
  }
}

/// States existing cells: a state, or those of one kind in a .pos file that is named after them, or of each
/// kind in numbers.
void setCells(Request& request, const Value& value, std::vector<Source> Request::*states,
              std::optional<Source> SpeciesRequest::*cells) {
  const Source source = sourceIn(value);
  if (isState(source))
    (request.*states).push_back(source);
  else if (source.given)
    for (const StateTable& table : source.given->tables)
      located(source.string(),
              [&] { speciesNamed(request, text(parseValue(name(), table.name))).*cells = source; });
  else
    cellsInFile(request, source.string()).*cells = source;
}

/// The option for the number of cells of one of packCells' types.
Setting countOption(const char* option, const char* cellName, const char* help) {
  Setting made = setting(option, {count()}, help, [cellName](Request& s, const Values& v) {
    speciesNamed(s, cellName).count = whole(v[0]);
  });
  made.countOf = cellName;
  return made.ofCell({"count"}).byDefault("0").alsoOfPackCells();
}

void setEllipsoid(Request& s, const Values& v) {
  SpeciesRequest& species = speciesNamed(s, text(v[0]));
  species.count = whole(v[1]);
  if (species.meshFile) {  // that of config.xml, with its scale
    species.meshFile.reset();
    species.meshScale.reset();
    species.meshFrame.reset();
  }
  species.ellipsoidAxes = Vec3(real(v[2]), real(v[3]), real(v[4]));
}

void setMesh(Request& s, const Values& v) {
  SpeciesRequest& species = speciesNamed(s, text(v[0]));
  species.count = whole(v[1]);
  species.ellipsoidAxes.reset();
  species.meshFile = sourceIn(v[2]);
}

void setOrientation(Request& s, const Values& v) {
  SpeciesRequest& species = speciesNamed(s, text(v[0]));
  species.axis = Vec3(real(v[1]), real(v[2]), real(v[3]));
  species.spread = real(v[4]);
}

/// Files of states, as they are stated; files of other cells belong to species.
std::vector<Values> listed(const std::vector<Source>& states) {
  std::vector<Values> all;
  for (const Source& state : states) all.push_back({*toValue(state)});
  return all;
}

}  // namespace

std::vector<Setting> cellSettings() {
  using R = Request;
  const auto component = [](const char* name) { return number(name, "", -1e6, false, 1e6); };
  return {
      setting(
          "hematocrit", &R::hematocrit, regionHematocrit(),
          "volume of the red cells' meshes divided by that of the lumen; excludes --rbc and --plt; 0: red "
          "cells in regions alone")
          .withLetter('h')
          .alsoOfPackCells(),
      setting("discharge-hematocrit", &R::dischargeHematocrit, hematocrit(),
              "hematocrit of the blood that flows out of the lumen, instead of --hematocrit: that in it is "
              "lower by the Fåhraeus effect (Pries 1990)"),
      setting("plt_ratio", &R::plateletRatio, ratio(),
              "number of platelets per red cell of any species; with a hematocrit")
          .withoutTag()
          .byDefault(toText(packCellsPlateletRatio))
          .alsoOfPackCells(),
      countOption("rbc", "RBC", "red blood cells"),
      countOption("plt", "PLT", "platelets"),
      countOption("wbc", "WBC", "white blood cells"),
      countOption("vrbc", "vRBC",
                  "stage V gametocytes (ellipsoids, unless --cell-mesh or the case provides a mesh)"),
      countOption("rbc_m", "RBC_m", "mouse red cells"),
      countOption("plt_m", "PLT_m", "mouse platelets"),
      countOption("plt_mko", "PLT_mko", "mouse knock-out platelets"),
      setting("cell", {name(), count(), length("e1"), length("e2"), length("d")},
              "n custom ellipsoids, given by their full axis lengths", setEllipsoid)
          .ofCell({"count", "ellipsoid"})
          .alsoOfPackCells(),
      setting("cell-mesh", {name(), count(), file()},
              "n custom cells, from any closed mesh (STL, OFF, PLY, OBJ)", setMesh)
          .ofCell({"count", "file"}),
      setting("mesh-scale", {name(), meshScale()}, "length of a unit of the mesh file of that cell in µm",
              [](Request& s, const Values& v) { speciesNamed(s, text(v[0])).meshScale = real(v[1]); })
          .ofCell({"scale"})
          .byDefault("1"),
      setting(
          "mesh-frame", {name(), meshFrames()},
          "axes of the mesh of that cell; hemocell: rotated and inflated as HemoCell's MESH_FROM_STL does; "
          "file: as in the file",
          [](Request& s, const Values& v) {
            speciesNamed(s, text(v[0])).meshFrame = meshFrameFromString(text(v[1]));
          })
          .ofCell({"frame"})
          .byDefault("hemocell"),
      setting("rbc-volume", &R::redCellVolume, number("v", "µm³", 0, true, 1e6),
              "volume of one red cell in the hematocrit (packCells: 97)")
          .byDefault("volume of the mesh")
          .withTag("redCellVolume"),
      setting("fluid-volume", &R::fluidVolume, flag(),
              "divide by the volume of the fluid nodes instead of the true lumen")
          .withoutTag()
          .statesKey("hematocritVolume"),
      choiceSetting("", &R::fluidVolume, "", {{"lumen", false}, {"fluid", true}},
                    "volume that the hematocrit refers to: the true lumen or the fluid nodes")
          .withTag("hematocritVolume"),
      setting(
          "fixed", {file()},
          "keep the cells of this .pos file (named after the cell) or state (.h5) fixed; counts include them",
          [](Request& s, const Values& v) { setCells(s, v[0], &R::fixedStates, &SpeciesRequest::fixed); })
          .writtenBy([](const R& r) { return listed(r.fixedStates); })
          .withTag("fixed")
          .mayRepeat(),
      setting("start", {file()},
              "start from the cells of this .pos file or state (.h5); missing cells are added at random "
              "positions; "
              "if the file has more, a random subset is kept. With check: examine the cells of this state, "
              "not those of .pos files",
              [](Request& s, const Values& v) { setCells(s, v[0], &R::startStates, &SpeciesRequest::start); })
          .writtenBy([](const R& r) { return listed(r.startStates); })
          .withTag("start")
          .mayRepeat(),
      setting(
          "blood", &R::blood, file(),
          "start from flowing blood: the cells of this state (.h5), as they are, repeated over the lumen; "
          "those "
          "that meet the wall or one another are left out, and more of them are added in the gaps until the "
          "hematocrit is met")
          .notForCheck(),
      setting("orient", {name(), component("x"), component("y"), component("z"), spread()},
              "keep the symmetry axis of that cell within this angle of the direction x y z", setOrientation)
          .ofCell({"axis", "spread"})
          .byDefault("any direction"),
      setting("rigid", {name()}, "with --soft: that cell keeps its shape",
              [](Request& s, const Values& v) { speciesNamed(s, text(v[0])).rigid = true; })
          .ofCell({"rigid"})
          .mayRepeat(),
      setting("minimum-distance-from-solid", {name(), distanceFromSolid()},
              "value that the case passes to setInitialMinimumDistanceFromSolid for that cell; HemoCell "
              "truncates it to whole µm",
              [](Request& s, const Values& v) {
                speciesNamed(s, text(v[0])).minimumDistanceFromSolid = real(v[1]);
              })
          .ofCell({"minimumDistanceFromSolid"})
          .byDefault("that in the C++ code beside config.xml, or 0"),
  };
}

}  // namespace packmesh::hemocell
