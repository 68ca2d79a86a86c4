// SPDX-License-Identifier: AGPL-3.0-or-later
// The settings of a job as they were resolved.
#include <nlohmann/json.hpp>

#include "hemocell_adapter/output/report.h"
#include "hemocell_adapter/settings/attribute_tables.h"
#include "hemocell_adapter/settings/settings_table.h"

namespace packmesh::hemocell {
namespace {

Report vectorOf(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

Report fileOf(const std::optional<std::filesystem::path>& file) {
  return file ? Report(file->string()) : Report(nullptr);
}

const char* axisName(int axis) {
  constexpr const char* names[] = {"x", "y", "z"};
  return names[axis];
}

Report solidOf(const SolidRequest& solid) {
  Report body;
  switch (solid.kind) {
    case SolidRequest::Kind::box:
      return {{"kind", "box"}, {"size", vectorOf(solid.size)}, {"origin", vectorOf(solid.origin)}};
    case SolidRequest::Kind::cylinder:
      body = {{"kind", "cylinder"},
              {"axis", axisName(solid.axis)},
              {"radius", solid.radius},
              {"length", solid.length}};
      break;
    case SolidRequest::Kind::sphere:
      body = {{"kind", "sphere"}, {"radius", solid.radius}};
      break;
    case SolidRequest::Kind::mesh:
      return {{"kind", "mesh"},
              {"file", solid.file.string()},
              {"scale", solid.scale},
              {"offset", vectorOf(solid.origin)},
              {"openAxis", solid.openAxis ? Report(axisName(*solid.openAxis)) : Report(nullptr)}};
  }
  body["center"] = solid.center ? vectorOf(*solid.center) : Report(nullptr);
  return body;
}

Report containerOf(const Job& job) {
  if (!job.container) return nullptr;
  Report container;
  container["lumen"] = job.container->lumen ? solidOf(*job.container->lumen) : Report(nullptr);
  container["obstacles"] = Report::array();
  for (const SolidRequest& solid : job.container->obstacles) container["obstacles"].push_back(solidOf(solid));
  container["nodes"] = job.container->nodes ? vectorOf(*job.container->nodes) : Report(nullptr);
  return container;
}

Report valueOf(const std::optional<Value>& value) {
  if (!value) return nullptr;
  return std::visit(
      [](const auto& v) -> Report {
        if constexpr (std::is_same_v<std::decay_t<decltype(v)>, Vec3>)
          return vectorOf(v);
        else
          return v;
      },
      *value);
}

Report growthOf(const GrowthSettings& growth) {
  Report all;
  for (const auto& parameter : growthParameters()) all[parameter.name] = valueOf(parameter.get(growth));
  return all;
}

/// Files with existing cells, per species that has one.
Report filesOf(const Job& job, std::string CellSpecies::*file) {
  Report files = Report::array();
  for (const CellSpecies& species : job.species)
    if (!(species.*file).empty()) files.push_back(species.*file);
  return files;
}

}  // namespace

Report configurationOf(const Scene& scene) {
  const bool cat = scene.method == Method::cat;
  const bool box = scene.boxSize && !(scene.container && scene.container->lumen);
  Report all;
  for (const Setting& setting : settingsTable())
    if (!setting.tag.empty() && setting.get) all[setting.tag] = valueOf(setting.get(scene));
  all["config"] = scene.config ? Report(scene.config->file.string()) : Report(nullptr);
  all["boxSize"] = scene.boxSize ? vectorOf(*scene.boxSize) : Report(nullptr);
  all["container"] = containerOf(scene);
  all["preInlet"] = nullptr;
  all["preInletSlice"] = nullptr;
  all["preInletRange"] = Report::array();
  if (scene.preInlet) {
    all["preInlet"] =
        std::string(1, "XYZ"[scene.preInlet->axis]) + (scene.preInlet->atHighEnd ? "pos" : "neg");
    if (scene.preInlet->slice) all["preInletSlice"] = toString(*scene.preInlet->slice);
    for (const NodeRange& range : scene.preInlet->ranges) all["preInletRange"].push_back(toString(range));
  }
  all["regions"] = Report::array();
  for (const RegionRequest& region : scene.regions)
    all["regions"].push_back({{"hematocrit", region.hematocrit}, {"body", solidOf(region.body)}});
  all["fixed"] = filesOf(scene, &CellSpecies::fixedFrom);
  all["start"] = filesOf(scene, &CellSpecies::startFrom);
  all["dx"] = scene.dx;
  all["walls"] = nullptr;
  if (scene.walls || box) all["walls"] = scene.walls.value_or("").empty() ? "none" : *scene.walls;
  all["ends"] = scene.periodicEnds.value_or(false) ? "periodic" : "closed";
  all["keep-all"] = scene.keepAll;
  if (!cat) all["builder"] = nullptr;
  all["growth"] = cat ? growthOf(scene.growth) : Report(nullptr);
  all["clearance"] = scene.clearances.membranes;
  all["clearanceAskedFor"] = scene.largestClearance ? "max" : scene.autoClearance ? "auto" : "stated";
  all["wallClearance"] = scene.clearances.wall;
  all["wallClearanceAskedFor"] = scene.autoWallClearance ? "auto" : "stated";
  all["maxTime"] = scene.maxSeconds > 0.0 ? Report(scene.maxSeconds) : Report(nullptr);
  all["maxIterations"] = scene.maxIterations.value_or(Limits().maxSweeps);
  all["tile"] = scene.tiles;
  all["export"] = scene.exports;
  all["checkpointEvery"] = scene.checkpointEvery > 0.0 ? Report(scene.checkpointEvery) : Report(nullptr);
  all["restart"] = fileOf(scene.restart);
  return all;
}

std::array<bool, 3> endAxes(const Job& job) {
  std::array<bool, 3> ends{};
  const auto allBut = [&](const std::string& walls) {
    for (int k = 0; k < 3; ++k) ends[k] = walls.find("xyz"[k]) == std::string::npos;
  };
  if (job.container && job.container->lumen) {
    const SolidRequest& solid = *job.container->lumen;
    if (solid.kind == SolidRequest::Kind::cylinder) ends[solid.axis] = true;
    if (solid.kind == SolidRequest::Kind::mesh && solid.openAxis) ends[*solid.openAxis] = true;
    if (solid.kind == SolidRequest::Kind::box)
      allBut(job.walls.value_or(job.periodicEnds.value_or(false) ? "" : "xyz"));
  } else if (job.boxSize || !job.config->domain.geometry) {
    allBut(job.walls.value_or(""));
  } else {
    ends[job.preInlet ? job.preInlet->axis : 0] = true;
  }
  return ends;
}

}  // namespace packmesh::hemocell
