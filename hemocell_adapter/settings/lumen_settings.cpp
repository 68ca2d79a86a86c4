// SPDX-License-Identifier: AGPL-3.0-or-later
// Request of the lumen.
#include <algorithm>

#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/settings/setting_groups.h"
#include "hemocell_adapter/settings/value_specs.h"

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

}  // namespace packmesh::hemocell
