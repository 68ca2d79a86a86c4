// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/settings_table.h"

#include <algorithm>

#include "hemocell_adapter/settings/packing_settings.h"
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
  return {
      option,    0,
      "",        false,
      {count()}, "0",
      help,      Topic::cells,
      true,      [cellName](Settings& s, const Values& v) { speciesNamed(s, cellName).count = whole(v[0]); }};
}

std::vector<Setting> cellSettings() {
  return {
      {"hematocrit",
       'h',
       "hematocrit",
       false,
       {hematocrit()},
       "",
       "share of the lumen that red-cell meshes fill; excludes --rbc and --plt",
       Topic::cells,
       true,
       [](Settings& s, const Values& v) { s.hematocrit = real(v[0]); }},
      {"plt_ratio",
       0,
       "",
       false,
       {ratio()},
       "0.07",
       "platelets per red cell, those of all species counted; with a hematocrit",
       Topic::cells,
       true,
       [](Settings& s, const Values& v) { s.plateletRatio = real(v[0]); }},
      countOption("rbc", "RBC", "red blood cells"),
      countOption("plt", "PLT", "platelets"),
      countOption("wbc", "WBC", "white blood cells"),
      countOption("vrbc", "vRBC",
                  "stage V gametocytes (ellipsoids, unless --cell-mesh or the case has a mesh)"),
      countOption("rbc_m", "RBC_m", "mouse red cells"),
      countOption("plt_m", "PLT_m", "mouse platelets"),
      countOption("plt_mko", "PLT_mko", "mouse knock-out platelets"),
      {"cell",
       0,
       "",
       false,
       {name(), count(), length("e1"), length("e2"), length("d")},
       "",
       "n ellipsoids of your own, full axis lengths",
       Topic::cells,
       true,
       [](Settings& s, const Values& v) {
         SpeciesRequest& species = speciesNamed(s, text(v[0]));
         species.count = whole(v[1]);
         if (species.meshFile) {  // that of config.xml, with its scale
           species.meshFile.reset();
           species.meshScale.reset();
           species.meshFrame.reset();
         }
         species.ellipsoidAxes = Vec3(real(v[2]), real(v[3]), real(v[4]));
       }},
      {"cell-mesh",
       0,
       "",
       false,
       {name(), count(), file()},
       "",
       "n cells of your own, any closed mesh (STL, OFF, PLY, OBJ)",
       Topic::cells,
       false,
       [](Settings& s, const Values& v) {
         SpeciesRequest& species = speciesNamed(s, text(v[0]));
         species.count = whole(v[1]);
         species.ellipsoidAxes.reset();
         species.meshFile = text(v[2]);
       }},
      {"mesh-scale",
       0,
       "",
       false,
       {name(), meshScale()},
       "1",
       "unit of that cell's mesh file",
       Topic::cells,
       false,
       [](Settings& s, const Values& v) { speciesNamed(s, text(v[0])).meshScale = real(v[1]); }},
      {"mesh-frame",
       0,
       "",
       false,
       {name(), meshFrames()},
       "hemocell",
       "axes of that cell's mesh: turned and inflated as HemoCell's MESH_FROM_STL does, or as in the file",
       Topic::cells,
       false,
       [](Settings& s, const Values& v) {
         speciesNamed(s, text(v[0])).meshFrame = meshFrameFromString(text(v[1]));
       }},
      {"rbc-volume",
       0,
       "redCellVolume",
       false,
       {number("v", "µm³", 0, true, 1e6)},
       "volume of the mesh",
       "count red cells by this volume (packCells: 97)",
       Topic::cells,
       false,
       [](Settings& s, const Values& v) { s.redCellVolume = real(v[0]); }},
      {"fluid-volume",
       0,
       "",
       true,
       {flag()},
       "no",
       "hematocrit of the volume of the fluid nodes, not of the true lumen",
       Topic::cells,
       false,
       [](Settings& s, const Values& v) { s.fluidVolume = yes(v[0]); }},
      {"",
       0,
       "hematocritVolume",
       false,
       {choice("", {"lumen", "fluid"})},
       "lumen",
       "what the hematocrit is a share of: the true lumen or the fluid nodes",
       Topic::cells,
       false,
       [](Settings& s, const Values& v) { s.fluidVolume = text(v[0]) == "fluid"; }},
      {"fixed",
       0,
       "fixed",
       false,
       {file()},
       "",
       "the cells of this .pos file (named like the cell) stay where they are; counts include them",
       Topic::cells,
       false,
       [](Settings& s, const Values& v) { cellsInFile(s, text(v[0])).fixed = text(v[0]); },
       true},
      {"start",
       0,
       "start",
       false,
       {file()},
       "",
       "begin with the cells of this .pos file: more are added at random, of too many some are drawn",
       Topic::cells,
       false,
       [](Settings& s, const Values& v) { cellsInFile(s, text(v[0])).start = text(v[0]); },
       true},
      {"orient",
       0,
       "",
       false,
       {name(), number("x", "", -1e6, false, 1e6), number("y", "", -1e6, false, 1e6),
        number("z", "", -1e6, false, 1e6), spread()},
       "any direction",
       "the thin axis of that cell stays within this angle of the direction x y z",
       Topic::cells,
       false,
       [](Settings& s, const Values& v) {
         SpeciesRequest& species = speciesNamed(s, text(v[0]));
         species.axis = Vec3(real(v[1]), real(v[2]), real(v[3]));
         species.spread = real(v[4]);
       }},
      {"minimum-distance-from-solid",
       0,
       "",
       false,
       {name(), distanceFromSolid()},
       "of the C++ code beside config.xml, or 0",
       "what the case passes to setInitialMinimumDistanceFromSolid for that cell, which HemoCell truncates "
       "to whole µm",
       Topic::cells,
       false,
       [](Settings& s, const Values& v) {
         speciesNamed(s, text(v[0])).minimumDistanceFromSolid = real(v[1]);
       }},
  };
}

SolidRequest& commandLineSolid(Settings& s, SolidRequest::Kind kind, const char* option) {
  if (!s.container) s.container.emplace();
  SolidRequest& solid = s.container->lumen.emplace();
  solid.kind = kind;
  solid.where = std::string("option '--") + option + "'";
  return solid;
}

std::vector<Setting> lumenSettings() {
  return {
      {"cylinder",
       0,
       "",
       false,
       {plain(Kind::axis, "axis"), length("radius"), length("length")},
       "",
       "a round tube instead of sizes or a case's geometry, low corner at the origin",
       Topic::lumen,
       false,
       [](Settings& s, const Values& v) {
         SolidRequest& solid = commandLineSolid(s, SolidRequest::Kind::cylinder, "cylinder");
         solid.axis = int(whole(v[0]));
         solid.radius = real(v[1]);
         solid.length = real(v[2]);
       }},
      {"sphere",
       0,
       "",
       false,
       {length("radius")},
       "",
       "a sphere, low corner at the origin",
       Topic::lumen,
       false,
       [](Settings& s, const Values& v) {
         commandLineSolid(s, SolidRequest::Kind::sphere, "sphere").radius = real(v[0]);
       }},
      {"vessel",
       0,
       "",
       false,
       {file(), meshScale()},
       "",
       "any watertight mesh; coordinates times factor are µm of the .pos files",
       Topic::lumen,
       false,
       [](Settings& s, const Values& v) {
         SolidRequest& solid = commandLineSolid(s, SolidRequest::Kind::mesh, "vessel");
         solid.file = text(v[0]);
         solid.scale = real(v[1]);
       }},
      {"open-axis",
       0,
       "",
       false,
       {plain(Kind::axis, "axis")},
       "closed all around",
       "the --vessel is open along this axis (flat caps at both ends)",
       Topic::lumen,
       false,
       [](Settings& s, const Values& v) {
         if (!s.container) s.container.emplace();
         if (!s.container->lumen) commandLineSolid(s, SolidRequest::Kind::mesh, "open-axis");
         s.container->lumen->openAxis = int(whole(v[0]));
       }},
      {"walls",
       0,
       "walls",
       false,
       {plain(Kind::axes, "axes")},
       "none for a box from the command line",
       "axes (xyz, or none) along which a box ends in walls",
       Topic::lumen,
       false,
       [](Settings& s, const Values& v) { s.walls = text(v[0]); }},
      {"ends",
       0,
       "ends",
       false,
       {choice("kind", {"closed", "periodic"})},
       "closed; periodic for a box under the name packCells",
       "open ends of a vessel, faces of a box: cells stay inside, where HemoCell keeps them, or wrap around",
       Topic::lumen,
       false,
       [](Settings& s, const Values& v) { s.periodicEnds = text(v[0]) == "periodic"; }},
      {"pre-inlet",
       0,
       "preInlet",
       false,
       {choice("direction", {"Xneg", "Xpos", "Yneg", "Ypos", "Zneg", "Zpos"})},
       "of the C++ code beside config.xml",
       "pack the inlet of a case with a <preInlet>: the direction in its C++ code (Direction::Xpos)",
       Topic::lumen,
       false,
       [](Settings& s, const Values& v) { s.preInlet = text(v[0]); }},
      {"pre-inlet-slice",
       0,
       "preInletSlice",
       false,
       {plain(Kind::plane, "n")},
       "of the C++ code, or the outermost with fluid",
       "plane of nodes that the case passes to preInletFromSlice: 101, last, last-5",
       Topic::lumen,
       false,
       [](Settings& s, const Values& v) { s.preInletSlice = whole(v[0]); }},
      {"pre-inlet-range",
       0,
       "preInletRange",
       false,
       {plain(Kind::axis, "axis"), plain(Kind::plane, "lo"), plain(Kind::plane, "hi")},
       "of the C++ code, or all of the plane",
       "nodes of that plane which the inlet is made of, where it has several outlines: y 0 42",
       Topic::lumen,
       false,
       [](Settings& s, const Values& v) {
         const NodeRange range{int(whole(v[0])), whole(v[1]), whole(v[2])};
         auto& all = s.preInletRanges;
         all.erase(
             std::remove_if(all.begin(), all.end(), [&](const NodeRange& r) { return r.axis == range.axis; }),
             all.end());
         all.push_back(range);
       },
       true},
      {"keep-all",
       0,
       "",
       true,
       {flag()},
       "no",
       "with packCells: no cell crosses a face of the box, so that HemoCell keeps all; packMesh's default",
       Topic::lumen,
       false,
       [](Settings& s, const Values& v) { s.keepAll = yes(v[0]); }},
      {"dx",
       0,
       "",
       false,
       {number("dx", "µm", 0, true, 100)},
       "0.5",
       "lattice spacing of the simulation, without a config.xml",
       Topic::lumen,
       false,
       [](Settings& s, const Values& v) { s.dx = real(v[0]); }},
      {"box",
       0,
       "",
       true,
       {flag()},
       "",
       "with check: the .pos files of a box, not of a case",
       Topic::lumen,
       false,
       [](Settings& s, const Values& v) { s.checkBox = yes(v[0]); }},
  };
}

/// Options that say how to pack what check would find packed are let be, so that a command can be repeated
/// with `check`; these ask for something that check does not do.
constexpr const char* packingOnly[] = {"state", "restart", "checkpoint-every", "report",
                                       "vtp",   "pov",     "vtp-meshes",       "export",
                                       "tile",  "dry-run", "validate",         "realisations"};

}  // namespace

const std::vector<Setting>& settingsTable() {
  static const std::vector<Setting> table = [] {
    std::vector<Setting> all;
    for (auto part : {cellSettings(), lumenSettings(), packingSettings()})
      all.insert(all.end(), part.begin(), part.end());
    for (const char* option : packingOnly)
      std::find_if(all.begin(), all.end(), [&](const Setting& s) {
        return std::string(option) == s.option;
      })->packingOnly = true;
    return all;
  }();
  return table;
}

}  // namespace packmesh::hemocell
