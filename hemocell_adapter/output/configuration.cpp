// SPDX-License-Identifier: AGPL-3.0-or-later
// The settings of a run as they were resolved.
#include <nlohmann/json.hpp>

#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/output/report.h"
#include "hemocell_adapter/settings/attribute_tables.h"
#include "hemocell_adapter/settings/request_json.h"
#include "hemocell_adapter/settings/settings_table.h"

namespace packmesh::hemocell {
namespace {

Report vectorOf(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

Report fileOf(const std::optional<std::filesystem::path>& file) {
  return file ? Report(file->string()) : Report(nullptr);
}

/// A body. Instead of a file there may be numbers.
Report solidOf(const SolidRequest& solid) {
  Report body = jsonOf(solid);
  if (solid.file.given) body["file"] = inTermsOfUser(solid.file.string());
  return body;
}

Report regionOf(const RegionRequest& region) {
  Report all = jsonOf(region);
  all["body"] = solidOf(region.body);
  return all;
}

Report containerOf(const Request& request) {
  if (!request.container) return nullptr;
  Report container;
  container["lumen"] = request.container->lumen ? solidOf(*request.container->lumen) : Report(nullptr);
  container["obstacles"] = Report::array();
  for (const SolidRequest& solid : request.container->obstacles)
    container["obstacles"].push_back(solidOf(solid));
  container["nodes"] = request.container->nodes ? vectorOf(*request.container->nodes) : Report(nullptr);
  return container;
}

Report catParametersOf(const CatSettings& cat) {
  Report all;
  for (const auto& parameter : catParameters())
    all[parameter.name] = jsonOf(*parameter.get(cat.growth), parameter.value);
  return all;
}

/// Files with existing cells, per species that has one.
Report filesOf(const Problem& problem, std::string CellSpecies::*file) {
  Report files = Report::array();
  for (const CellSpecies& species : problem.species)
    if (!(species.*file).empty()) files.push_back(inTermsOfUser(species.*file));
  return files;
}

}  // namespace

Report configurationOf(const Problem& problem, const OutputRequest& output, const Clearances& clearances) {
  Request request = problem.request;
  request.output = output;
  request.hematocrit = problem.hematocrit;
  const bool cat = request.method == Method::cat;
  const bool box = request.boxSize && !(request.container && request.container->lumen);
  Report all;
  for (const Setting& setting : settingsTable())
    if (!setting.tag.empty() && setting.get) {
      const std::optional<Value> value = setting.get(request);
      const auto* const numbers = value ? std::get_if<std::shared_ptr<const Given>>(&*value) : nullptr;
      if (numbers) all[setting.tag] = inTermsOfUser((*numbers)->what);
      if (!numbers) all[setting.tag] = value ? jsonOf(*value, setting.values[0]) : Report(nullptr);
    }
  all["config"] = problem.simulation ? Report(problem.simulation->file.string()) : Report(nullptr);
  all["boxSize"] = request.boxSize ? vectorOf(*request.boxSize) : Report(nullptr);
  all["container"] = containerOf(request);
  all["preInlet"] = nullptr;
  all["preInletSlice"] = nullptr;
  all["preInletRange"] = Report::array();
  if (problem.preInlet) {
    all["preInlet"] =
        std::string(1, "XYZ"[problem.preInlet->axis]) + (problem.preInlet->atHighEnd ? "pos" : "neg");
    if (problem.preInlet->slice) all["preInletSlice"] = toString(*problem.preInlet->slice);
    for (const NodeRange& range : problem.preInlet->ranges) all["preInletRange"].push_back(toString(range));
  }
  all["regions"] = Report::array();
  for (const RegionRequest& region : request.regions) all["regions"].push_back(regionOf(region));
  all["fixed"] = filesOf(problem, &CellSpecies::fixedFrom);
  all["start"] = filesOf(problem, &CellSpecies::startFrom);
  all["dx"] = request.dx;
  all["walls"] = nullptr;
  if (request.walls || box) all["walls"] = request.walls.value_or("").empty() ? "none" : *request.walls;
  all["ends"] = request.periodicEnds.value_or(false) ? "periodic" : "closed";
  all["keep-all"] = request.keepAll;
  if (!cat) all["builder"] = nullptr;
  all[catTag] = cat ? catParametersOf(request.cat) : Report(nullptr);
  all["clearance"] = clearances.membranes;
  all["clearanceAskedFor"] = request.largestClearance     ? "max"
                             : request.choosesClearance() ? "auto"
                                                          : "stated";
  all["wallClearance"] = clearances.wall;
  all["wallClearanceAskedFor"] = request.choosesWallClearance() ? "auto" : "stated";
  all["maxTime"] = request.maxSeconds > 0.0 ? Report(request.maxSeconds) : Report(nullptr);
  all["maxIterations"] = request.maxIterations.value_or(Limits().maxSweeps);
  all["tile"] = request.tiles;
  all["export"] = request.output.exports;
  all["checkpointEvery"] =
      request.output.checkpointEvery > 0.0 ? Report(request.output.checkpointEvery) : Report(nullptr);
  all["restart"] = fileOf(request.restart);
  return all;
}

}  // namespace packmesh::hemocell
