// SPDX-License-Identifier: AGPL-3.0-or-later
// What is packed.
#include "hemocell_adapter/settings/setting_groups.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

using namespace specs;

/// The request for the cells called like the file.
SpeciesRequest& cellsInFile(Settings& settings, const std::string& file) {
  try {
    return speciesNamed(settings, text(parseValue(name(), std::filesystem::path(file).stem().string())));
  } catch (const InputError& error) {
    throw InputError(file + ": the name before .pos is that of the cells; " + error.what());
  }
}

/// The option that asks for `n` cells of one of packCells' types.
Setting countOption(const char* option, const char* cellName, const char* help) {
  return setting(option, {count()}, help,
                 [cellName](Settings& s, const Values& v) { speciesNamed(s, cellName).count = whole(v[0]); })
      .byDefault("0")
      .alsoOfPackCells();
}

void setEllipsoid(Settings& s, const Values& v) {
  SpeciesRequest& species = speciesNamed(s, text(v[0]));
  species.count = whole(v[1]);
  if (species.meshFile) {  // that of config.xml, with its scale
    species.meshFile.reset();
    species.meshScale.reset();
    species.meshFrame.reset();
  }
  species.ellipsoidAxes = Vec3(real(v[2]), real(v[3]), real(v[4]));
}

void setMesh(Settings& s, const Values& v) {
  SpeciesRequest& species = speciesNamed(s, text(v[0]));
  species.count = whole(v[1]);
  species.ellipsoidAxes.reset();
  species.meshFile = text(v[2]);
}

void setOrientation(Settings& s, const Values& v) {
  SpeciesRequest& species = speciesNamed(s, text(v[0]));
  species.axis = Vec3(real(v[1]), real(v[2]), real(v[3]));
  species.spread = real(v[4]);
}

}  // namespace

std::vector<Setting> cellSettings() {
  using R = RunSettings;
  const auto component = [](const char* name) { return number(name, "", -1e6, false, 1e6); };
  return {
      setting("hematocrit", &R::hematocrit, hematocrit(),
              "share of the lumen that red-cell meshes fill; excludes --rbc and --plt")
          .withLetter('h')
          .alsoOfPackCells(),
      setting("plt_ratio", {ratio()},
              "platelets per red cell, those of all species counted; with a hematocrit",
              [](Settings& s, const Values& v) { s.plateletRatio = real(v[0]); })
          .byDefault("0.07")
          .alsoOfPackCells(),
      countOption("rbc", "RBC", "red blood cells"),
      countOption("plt", "PLT", "platelets"),
      countOption("wbc", "WBC", "white blood cells"),
      countOption("vrbc", "vRBC",
                  "stage V gametocytes (ellipsoids, unless --cell-mesh or the case has a mesh)"),
      countOption("rbc_m", "RBC_m", "mouse red cells"),
      countOption("plt_m", "PLT_m", "mouse platelets"),
      countOption("plt_mko", "PLT_mko", "mouse knock-out platelets"),
      setting("cell", {name(), count(), length("e1"), length("e2"), length("d")},
              "n ellipsoids of your own, full axis lengths", setEllipsoid)
          .alsoOfPackCells(),
      setting("cell-mesh", {name(), count(), file()},
              "n cells of your own, any closed mesh (STL, OFF, PLY, OBJ)", setMesh),
      setting("mesh-scale", {name(), meshScale()}, "unit of that cell's mesh file",
              [](Settings& s, const Values& v) { speciesNamed(s, text(v[0])).meshScale = real(v[1]); })
          .byDefault("1"),
      setting("mesh-frame", {name(), meshFrames()},
              "axes of that cell's mesh: turned and inflated as HemoCell's MESH_FROM_STL does, or as in the "
              "file",
              [](Settings& s, const Values& v) {
                speciesNamed(s, text(v[0])).meshFrame = meshFrameFromString(text(v[1]));
              })
          .byDefault("hemocell"),
      setting("rbc-volume", &R::redCellVolume, number("v", "µm³", 0, true, 1e6),
              "count red cells by this volume (packCells: 97)")
          .byDefault("volume of the mesh")
          .withTag("redCellVolume"),
      flagSetting("fluid-volume", &R::fluidVolume,
                  "hematocrit of the volume of the fluid nodes, not of the true lumen")
          .withoutTag(),
      choiceSetting("", &R::fluidVolume, "", {{"lumen", false}, {"fluid", true}},
                    "what the hematocrit is a share of: the true lumen or the fluid nodes")
          .withTag("hematocritVolume"),
      setting("fixed", {file()},
              "the cells of this .pos file (named like the cell) stay where they are; counts include them",
              [](Settings& s, const Values& v) { cellsInFile(s, text(v[0])).fixed = text(v[0]); })
          .withTag("fixed")
          .mayRepeat(),
      setting("start", {file()},
              "begin with the cells of this .pos file: more are added at random, of too many some are drawn",
              [](Settings& s, const Values& v) { cellsInFile(s, text(v[0])).start = text(v[0]); })
          .withTag("start")
          .mayRepeat(),
      setting("orient", {name(), component("x"), component("y"), component("z"), spread()},
              "the thin axis of that cell stays within this angle of the direction x y z", setOrientation)
          .byDefault("any direction"),
      setting("minimum-distance-from-solid", {name(), distanceFromSolid()},
              "what the case passes to setInitialMinimumDistanceFromSolid for that cell, which HemoCell "
              "truncates to whole µm",
              [](Settings& s, const Values& v) {
                speciesNamed(s, text(v[0])).minimumDistanceFromSolid = real(v[1]);
              })
          .byDefault("of the C++ code beside config.xml, or 0"),
  };
}

}  // namespace packmesh::hemocell
