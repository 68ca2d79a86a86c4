// SPDX-License-Identifier: AGPL-3.0-or-later
// Request of the lumen.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/settings/settings_table.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"
#include "packMesh/packing/state_file.h"
#include "packMesh/problem/execution.h"

namespace packmesh::hemocell {
namespace {

using namespace specs;

SolidRequest& commandLineSolid(Request& s, SolidRequest::Kind kind, const char* option) {
  if (!s.container) s.container.emplace();
  std::optional<int> openAxis;  // stated before the vessel
  if (const auto& before = s.container->lumen; before && before->file.empty()) openAxis = before->openAxis;
  SolidRequest& solid = s.container->lumen.emplace();
  solid.kind = kind;
  solid.openAxis = openAxis;
  solid.where = heading(option);
  return solid;
}

void setCylinder(Request& s, const Values& v) {
  SolidRequest& solid = commandLineSolid(s, SolidRequest::Kind::cylinder, "cylinder");
  solid.axis = int(whole(v[0]));
  solid.radius = real(v[1]);
  solid.length = real(v[2]);
}

void setVessel(Request& s, const Values& v) {
  SolidRequest& solid = commandLineSolid(s, SolidRequest::Kind::mesh, "vessel");
  solid.file = sourceIn(v[0]);
  solid.scale = real(v[1]);
}

void setOpenAxis(Request& s, const Values& v) {
  if (!s.container) s.container.emplace();
  if (!s.container->lumen) commandLineSolid(s, SolidRequest::Kind::mesh, "open-axis");
  s.container->lumen->openAxis = int(whole(v[0]));
}

void setPreInletRange(Request& s, const Values& v) {
  const NodeRange range{int(whole(v[0])), whole(v[1]), whole(v[2])};
  auto& all = s.preInletRanges;
  all.erase(std::remove_if(all.begin(), all.end(), [&](const NodeRange& r) { return r.axis == range.axis; }),
            all.end());
  all.push_back(range);
}

}  // namespace

std::vector<Setting> lumenSettings() {
  using R = Request;
  const ValueSpec axis = plain(Kind::axis, "axis");
  ValueSpec spacings = number("dx ...", "µm", 0, true, 100);
  spacings.kind = Kind::numbers;
  return {
      setting("cylinder", {axis, length("radius"), length("length")},
              "a cylinder instead of a box or the geometry of a case, low corner at the origin", setCylinder)
          .statesKey("container"),
      setting("sphere", {length("radius")}, "a sphere, low corner at the origin",
              [](Request& s, const Values& v) {
                commandLineSolid(s, SolidRequest::Kind::sphere, "sphere").radius = real(v[0]);
              })
          .statesKey("container"),
      setting("vessel", {file(), meshScale()},
              "a watertight mesh (.stl, .off, .ply, .obj; by the Python package .vtp, .vtu, .vtk, .msh); "
              "coordinates times factor are in µm",
              setVessel)
          .statesKey("container"),
      setting("open-axis", {axis}, "axis along which the --vessel is open (flat caps at both ends)",
              setOpenAxis)
          .statesKey("container")
          .byDefault("closed on all sides"),
      choiceSetting("flat-openings", &R::capOpenings, "kind", {{"cap", true}, {"refuse", false}},
                    "flat openings in the mesh of a vessel; cap: they are closed; refuse: an error"),
      setting("walls", &R::walls, plain(Kind::axes, "axes"),
              "axes (xyz, or none) along which the box ends in walls")
          .byDefault("none for a box from the command line"),
      setting(
          "ends", {choice("kind", {"closed", "periodic"})},
          "open ends of a vessel and faces of a box; closed: cells stay inside, where HemoCell keeps them; "
          "periodic: cells wrap around",
          [](Request& s, const Values& v) { s.periodicEnds = text(v[0]) == "periodic"; })
          .writtenBy([](const R& r) {
            return std::vector<Values>{{std::string(r.periodicEnds.value_or(false) ? "periodic" : "closed")}};
          })
          .byDefault("closed; periodic for a box under the name packCells")
          .withTag("ends"),
      setting("pre-inlet", {choice("direction", {"Xneg", "Xpos", "Yneg", "Ypos", "Zneg", "Zpos"})},
              "direction of the pre-inlet to pack, as in the C++ code of the case (Direction::Xpos)",
              [](Request& s, const Values& v) { s.preInlet = text(v[0]); })
          .writtenBy([](const R& r) { return std::vector<Values>{{*r.preInlet}}; })
          .byDefault("that in the C++ code beside config.xml, if it is a literal")
          .withTag("preInlet"),
      setting("pre-inlet-slice", {plain(Kind::plane, "n")},
              "plane of nodes that the case passes to preInletFromSlice: 101, last, last-5",
              [](Request& s, const Values& v) { s.preInletSlice = whole(v[0]); })
          .writtenBy([](const R& r) { return std::vector<Values>{{*r.preInletSlice}}; })
          .byDefault("that of autoPreinletFromBoundary in the C++ code, or the outermost with fluid")
          .withTag("preInletSlice"),
      setting("pre-inlet-range", {axis, plain(Kind::plane, "lo"), plain(Kind::plane, "hi")},
              "nodes of that plane that form the inlet, if the plane has several outlines: y 0 42",
              setPreInletRange)
          .writtenBy([](const R& r) {
            std::vector<Values> all;
            for (const NodeRange& range : r.preInletRanges)
              all.push_back({std::int64_t(range.axis), range.lo, range.hi});
            return all;
          })
          .byDefault("the whole plane")
          .withTag("preInletRange")
          .mayRepeat(),
      setting(
          "keep-all", &R::keepAll, flag(),
          "with packCells: no cell crosses a face of the box, so that HemoCell keeps all cells; default of "
          "packMesh")
          .withoutTag(),
      setting("dx", &R::dx, number("dx", "µm", 0, true, 100),
              "lattice spacing of the simulation, without a config.xml")
          .withoutTag(),
      setting(
          "also-dx", &R::alsoDx, spacings,
          "other lattice spacings at which HemoCell is to keep the same cells, with as many nodes more or "
          "fewer; where the frame of the .pos files depends on the spacing, a folder dx_... has them"),
      setting("box", {flag()}, "with check: check the .pos files of a box, not of a case",
              [](Request& s, const Values& v) { s.checkBox = yes(v[0]); })
          .statesKey("checkBox"),
  };
}

// Request of the cells.

namespace {

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

// Request of the method and its limits.

namespace {

Value numberOrAuto(const std::optional<double>& number) {
  return number ? Value(*number) : Value(std::string("auto"));
}

std::vector<Setting> softSettings() {
  using R = Request;
  return {
      setting("soft", {flag({"auto"})},
              "cells deform by HemoCell's membrane laws where undeformed ones cannot be packed easily: in "
              "capillaries, and up to a hematocrit of 0.9; the result is a state. auto (=auto): only where "
              "undeformed ones cannot be packed at all",
              [](Request& s, const Values& v) {
                s.deforming = isWord(v[0], "auto") ? Deforming::asLast
                              : yes(v[0])          ? Deforming::unlessEasy
                                                   : Deforming::no;
              })
          .readBy([](const R& r) {
            return r.deforming == Deforming::asLast ? Value(std::string("auto")) : Value(r.deforms());
          })
          .byDefault("false")
          .withTag("soft")
          .onlyFor(Method::relaxation)
          .notForCheck(),
      setting("max-force", &R::maxForce, number("f", "pN", 0, true, 1e6),
              "largest force on a vertex of a soft cell when HemoCell starts")
          .byDefault("10")
          .onlyFor(Method::relaxation)
          .notForCheck(),
      setting("max-volume-change", &R::maxVolumeChange, number("f", "fraction", 0, true, 1),
              "largest change of the volume of a soft cell")
          .byDefault("0.05")
          .onlyFor(Method::relaxation)
          .notForCheck(),
      setting("max-area-change", &R::maxAreaChange, number("f", "fraction", 0, true, 1),
              "largest change of the area of a soft cell")
          .byDefault("0.15")
          .onlyFor(Method::relaxation)
          .notForCheck(),
  };
}

}  // namespace

std::vector<Setting> methodSettings() {
  using R = Request;
  std::vector<Setting> all = {
      setting(
          "clearance", {clearance({"auto", "max"})},
          "minimum gap between membranes; auto: a tenth of dx, or as much of it as the hematocrit allows; "
          "max: the largest found within --max-time, or 60 s",
          [](Request& s, const Values& v) {
            s.clearance = numberIn(v[0]);
            s.largestClearance = isWord(v[0], "max");
          })
          .writtenBy([](const R& r) {
            return std::vector<Values>{
                {r.largestClearance ? Value(std::string("max")) : numberOrAuto(r.clearance)}};
          })
          .byDefault("auto")
          .withTag("clearance"),
      setting("wall-clearance", {clearance({"auto"})},
              "minimum gap between membrane and wall; auto: dx, or as much of it as the hematocrit allows",
              [](Request& s, const Values& v) { s.wallClearance = numberIn(v[0]); })
          .writtenBy([](const R& r) { return std::vector<Values>{{numberOrAuto(r.wallClearance)}}; })
          .byDefault("auto")
          .withTag("wallClearance"),
      setting("cell-free-layer", &R::cellFreeLayer, clearance(),
              "minimum distance between red cells and the wall")
          .byDefault("none"),
      setting("profile", &R::profile, plain(Kind::text, "file"),
              "distribution of the cells over the distance from the wall: a table, or 'developed' for a "
              "cell-free layer with platelets in it, as blood has after flowing for a while")
          .byDefault("none: random positions")
          .onlyFor(Method::relaxation),
      setting("seed", &R::seed, seed(), "seed of the random numbers; the same seed gives the same bytes"),
      setting("noRotate", {flag()}, "keep every orientation at 0 0 0 (symmetry axis along y)",
              [](Request& s, const Values& v) { s.rotate = !yes(v[0]); })
          .statesKey("rotate")
          .byDefault("false")
          .alsoOfPackCells(),
      setting("", &R::rotate, flag(), "false: keep every orientation at 0 0 0 (symmetry axis along y)")
          .withTag("rotate"),
      choiceSetting(
          "order", &R::inColumns, "kind", {{"random", false}, {"columns", true}},
          "initial arrangement; columns: rouleaux of the species with the largest volume, denser than any "
          "random packing, in periodic boxes"),
  };
  for (Setting& setting : softSettings()) all.push_back(std::move(setting));
  return all;
}

std::vector<Setting> limitSettings() {
  using R = Request;
  const ValueSpec sweeps = integer("n", "sweeps", 1, 1e15);
  return {
      setting(
          "max-time", &R::maxSeconds, number("s", "s", 0, true, 1e9),
          "time limit; if not all cells fit at once, fewer are packed first, which can take as long again. "
          "Then the run ends within 5 s, or within 2 s per 100,000 cells if that is more")
          .byDefault("no limit"),
      setting("max-iterations", &R::maxIterations, sweeps,
              "maximum number of relaxation sweeps or growth iterations (the search for the densest packing "
              "takes more)")
          .byDefault(std::to_string(Limits().maxSweeps)),
      setting("maxiter", &R::maxIterations, sweeps,
              "the same as --max-iterations, under the name it has in packCells")
          .withoutTag()
          .statesKey("maxIterations")
          .alsoOfPackCells(),
      setting("threads", &R::threads, integer("n", "threads", 1, maxThreads),
              "threads of each rank; the packing does not depend on their number")
          .byDefault("OMP_NUM_THREADS, SLURM_CPUS_PER_TASK, or all cores; with several ranks one")
          .withoutTag(),
      setting("best-effort", &R::bestEffort, flag(),
              "if the request is not feasible, write the densest certified packing that was found"),
      setting(
          "dry-run", &R::dryRun, flag(),
          "pack nothing; print volumes, numbers of cells, memory, time, and whether the request is feasible")
          .withoutTag()
          .notForCheck(),
      setting("validate", &R::validate, flag(), "pack nothing; only read the input and report errors")
          .withoutTag()
          .notForCheck(),
  };
}

// Request of the output, and ignored options of packCells.

std::vector<Setting> outputSettings() {
  using R = Request;
  using O = OutputRequest;
  const auto times = [](const char* axis) { return integer(axis, "", 1, 1e4); };
  return {
      setting("output-dir", &O::folder, plain(Kind::text, "folder"),
              "folder of the .pos files (with check: to read them from)")
          .byDefault("that of config.xml; without one the working directory")
          .withTag("outputDirectory"),
      setting("realisations", &R::realisations, times("n"),
              "number of packings, with consecutive seeds from --seed on, in folders realisation_1, "
              "realisation_2 ...")
          .notForCheck(),
      setting("tile", {times("nx"), times("ny"), times("nz")},
              "numbers of copies of the periodic box along each axis, in a larger box",
              [](Request& s, const Values& v) {
                s.tiles = {int(whole(v[0])), int(whole(v[1])), int(whole(v[2]))};
              })
          .writtenBy([](const R& r) {
            return std::vector<Values>{{Value(std::int64_t(r.tiles[0])), Value(std::int64_t(r.tiles[1])),
                                        Value(std::int64_t(r.tiles[2]))}};
          })
          .notForCheck(),
      setting(
          "export", {choice("format", {std::begin(exportFormats), std::end(exportFormats)})},
          fmt::format("also write the cells, with the meshes they need, for other programs: {} (vtk: same "
                      "as --vtp, vtk-meshes: --vtp-meshes)",
                      fmt::join(exportFormats, ", ")),
          [](Request& s, const Values& v) {
            if (std::find(s.output.exports.begin(), s.output.exports.end(), text(v[0])) ==
                s.output.exports.end())
              s.output.exports.push_back(text(v[0]));
          })
          .writtenBy([](const R& r) {
            std::vector<Values> all;
            for (const std::string& format : r.output.exports) all.push_back({format});
            return all;
          })
          .withTag("export")
          .mayRepeat(),
      setting(
          "undeformed", &O::undeformed, flag(),
          "write deformed cells undeformed to formats that hold poses (csv, espresso, extxyz, gsd, lammps, "
          "mirheo, npfem, vtk), which are refused otherwise; a warning says how many of these cells "
          "overlap"),
      setting(
          "checkpoint-every", &O::checkpointEvery, number("s", "s", 0, true, 1e9),
          "interval at which a checkpoint is saved beside the state file, to continue after an interruption")
          .byDefault("only at signals and at the end of a run that failed, with --state")
          .notForCheck(),
      setting("state", &O::stateFile, file(),
              "file of the state of the result, written with the .pos files; until then what is reached is "
              "saved in "
              "<name>.checkpoint.h5 at SIGUSR1, when interrupted, and if the run fails")
          .byDefault("state.h5 beside the .pos files, with --checkpoint-every")
          .withTag("stateFile")
          .notForCheck(),
      setting("restart", &R::restart, file(),
              "continue from a checkpoint, or a state; alone: with the command that started the run")
          .withoutTag()
          .notForCheck(),
      setting("pov", &O::povScene, flag(), "same as --vtp").withTag("povScene"),
      setting("vtp", &O::vtp, flag(),
              "write <Cell>.vtp for ParaView: the cells as points with their measurements, their meshes, "
              "and lumen.vtp"),
      setting("vtp-meshes", &O::vtpMeshes, flag(),
              "write <Cell>_cells.vtp: all membranes (about 60 kB per red cell)"),
      framesSetting(),
      setting("report", &O::reportFile, file(),
              "write a report: file.json, or file.html with an interactive view (and file.json beside it)"),
      setting("quiet", &R::quiet, flag(), "print only warnings and errors").withoutTag(),
      setting("verbose", &R::verbose, flag(), "print progress, and every violation that a check finds")
          .withoutTag(),
  };
}

std::vector<Setting> ignoredSettings() {
  return {
      setting("allowRotate", {flag()}, "orientations are random by default", [](Request&, const Values&) {})
          .withLetter('r')
          .alsoOfPackCells(),
      setting("scale", &Request::ignoredScale, number("s", "", 0, false, 1e9),
              "neighbour grid of packCells; packMesh has none")
          .withoutTag()
          .withLetter('s')
          .alsoOfPackCells()};
}

}  // namespace packmesh::hemocell
