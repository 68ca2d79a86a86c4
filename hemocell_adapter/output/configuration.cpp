// SPDX-License-Identifier: AGPL-3.0-or-later
// The settings of a job as they were resolved.
#include <nlohmann/json.hpp>

#include "hemocell_adapter/output/report.h"

namespace packmesh::hemocell {
namespace {

Report vectorOf(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

template <class T>
Report optionalOf(const std::optional<T>& value) {
  return value ? Report(*value) : Report(nullptr);
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

Report growthOf(const GrowthSettings& g) {
  return {{"initialScale", g.initialScale},
          {"spreadRounds", g.spreadRounds},
          {"barriers", g.barriers},
          {"iterations", g.maxIterations},
          {"rotationBound", g.rotationBound},
          {"translationBound", g.translationBound},
          {"padding", g.padding},
          {"linearisations", g.linearisations},
          {"alpha", g.alpha},
          {"beta", g.beta},
          {"centring", g.centring},
          {"shaking", g.shaking},
          {"patience", g.patience},
          {"stalledGrowth", g.stalledGrowth},
          {"relaxationSweeps", g.relaxationSweeps},
          {"giveUpAfter", g.giveUpAfter},
          {"attempts", g.attempts}};
}

const char* nameOf(PlaneSource planeSource) {
  switch (planeSource) {
    case PlaneSource::catFaces:
      return "cat-faces";
    case PlaneSource::chords:
      break;
  }
  return "chords";
}

/// Files that hold cells which are there, per species that has one.
Report filesOf(const Job& job, std::string JobSpecies::*file) {
  Report files = Report::array();
  for (const JobSpecies& species : job.species)
    if (!(species.*file).empty()) files.push_back(species.*file);
  return files;
}

}  // namespace

Report configurationOf(const Job& job) {
  const bool cat = job.method == Method::cat;
  const bool box = job.boxSize && !(job.container && job.container->lumen);
  Report all;
  all["config"] = job.config ? Report(job.config->file.string()) : Report(nullptr);
  all["boxSize"] = job.boxSize ? vectorOf(*job.boxSize) : Report(nullptr);
  all["container"] = containerOf(job);
  all["preInlet"] = nullptr;
  all["preInletSlice"] = nullptr;
  all["preInletRange"] = Report::array();
  if (job.preInlet) {
    all["preInlet"] = std::string(1, "XYZ"[job.preInlet->axis]) + (job.preInlet->atHighEnd ? "pos" : "neg");
    if (job.preInlet->slice) all["preInletSlice"] = toString(*job.preInlet->slice);
    for (const NodeRange& range : job.preInlet->ranges) all["preInletRange"].push_back(toString(range));
  }
  all["regions"] = Report::array();
  for (const RegionRequest& region : job.regions)
    all["regions"].push_back({{"hematocrit", region.hematocrit}, {"body", solidOf(region.body)}});
  all["fixed"] = filesOf(job, &JobSpecies::fixedFrom);
  all["start"] = filesOf(job, &JobSpecies::startFrom);
  all["dx"] = job.dx;
  all["walls"] = nullptr;
  if (job.walls || box) all["walls"] = job.walls.value_or("").empty() ? "none" : *job.walls;
  all["ends"] = job.periodicEnds.value_or(false) ? "periodic" : "closed";
  all["keep-all"] = job.keepAll;
  all["hematocrit"] = optionalOf(job.hematocrit);
  all["redCellVolume"] = optionalOf(job.redCellVolume);
  all["hematocritVolume"] = job.fluidVolume ? "fluid" : "lumen";
  all["method"] = cat ? "cat" : "relaxation";
  all["builder"] = cat ? Report(nameOf(job.planeSource.value_or(PlaneSource::chords))) : Report(nullptr);
  all["escape"] = job.escape;
  all["growth"] = cat ? growthOf(job.growth) : Report(nullptr);
  all["clearance"] = job.clearance;
  all["clearanceAskedFor"] = job.largestClearance ? "max" : job.autoClearance ? "auto" : "stated";
  all["wallClearance"] = job.wallClearance;
  all["wallClearanceAskedFor"] = job.autoWallClearance ? "auto" : "stated";
  all["seed"] = job.seed;
  all["rotate"] = job.rotate;
  all["order"] = job.inColumns ? "columns" : "random";
  all["cellFreeLayer"] = job.cellFreeLayer;
  all["maxTime"] = job.maxSeconds > 0.0 ? Report(job.maxSeconds) : Report(nullptr);
  all["maxIterations"] = job.maxIterations.value_or(Limits().maxSweeps);
  all["bestEffort"] = job.bestEffort;
  all["tile"] = job.tiles;
  all["realisations"] = job.realisations;
  all["export"] = job.exports;
  all["outputDirectory"] = job.outputDirectory.string();
  all["checkpointEvery"] = job.checkpointEvery > 0.0 ? Report(job.checkpointEvery) : Report(nullptr);
  all["stateFile"] = fileOf(job.stateFile);
  all["restart"] = fileOf(job.restart);
  all["povScene"] = job.povScene;
  all["vtp"] = job.vtp;
  all["vtpMeshes"] = job.vtpMeshes;
  all["report"] = fileOf(job.reportFile);
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
