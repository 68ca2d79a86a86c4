// SPDX-License-Identifier: AGPL-3.0-or-later
// The settings of a run as they were resolved.
#include "hemocell_adapter/output/report.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/realisation_folders.h"
#include "hemocell_adapter/settings/attribute_tables.h"
#include "hemocell_adapter/settings/command_line.h"
#include "hemocell_adapter/settings/request_json.h"
#include "hemocell_adapter/settings/settings_table.h"
#include "packMesh/analysis/cell_measures.h"
#include "packMesh/core/version.h"

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
      const auto* const numbers = value ? std::get_if<std::shared_ptr<const MemoryInput>>(&*value) : nullptr;
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

namespace {

Report coordinatesOf(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

/// For gaps that were not measured because they are large: null.
Report gapOf(double gap) {
  return std::isfinite(gap) ? Report(gap) : Report(nullptr);
}

Report lumenOf(const Problem& problem) {
  const Container& container = *problem.lumen.container;
  Report lumen;
  lumen["description"] = container.describe();
  lumen["note"] = problem.lumen.note;
  lumen["volume"] = container.volume();
  const Box bounds = container.bounds();
  lumen["low"] = coordinatesOf(bounds.lo);
  lumen["high"] = coordinatesOf(bounds.hi);
  lumen["period"] = coordinatesOf(container.period());
  lumen["wall"] = container.wall() != nullptr;
  lumen["lattice"] = nullptr;
  if (problem.lumen.lattice) {
    const auto nodes = problem.lumen.lattice->nodes();
    lumen["lattice"] = {{"nodes", {nodes[0], nodes[1], nodes[2]}},
                        {"dx", problem.lumen.lattice->dx()},
                        {"fluidNodes", problem.lumen.lattice->fluidNodes()},
                        {"fluidVolume", problem.lumen.lattice->fluidVolume()}};
  }
  return lumen;
}

Report speciesOf(const Packing& packing) {
  Report all = Report::array();
  for (std::size_t s = 0; s < packing.problem->species.size(); ++s) {
    const CellSpecies& species = packing.problem->species[s];
    Report one;
    one["name"] = species.name;
    one["origin"] = species.origin;
    one["redCell"] = species.redCell;
    one["request"] = packing.checked ? "in the file" : requestText(species);
    one["asked"] = species.count;
    one["stock"] = species.stock;
    one["placed"] = packing.tally.counts[s];
    one["keptByHemoCell"] =
        knowsAcceptance(*packing.problem) ? Report(packing.kept.kept[s]) : Report(nullptr);
    one["meshVolume"] = species.shape->volume();
    one["hemocellVolume"] =
        species.model.hemocellVolume ? Report(*species.model.hemocellVolume) : Report(nullptr);
    one["vertices"] = species.shape->mesh().vertices.size();
    one["triangles"] = species.shape->mesh().triangles.size();
    one["size"] = coordinatesOf(boundingBox(species.shape->mesh()).size());
    one["volumeFraction"] = packing.tally.meshVolume[s] / packing.problem->lumen.container->volume();
    one["minimumDistanceFromSolid"] = species.minimumDistanceFromSolid;
    const bool inFile = species.mostCells() > 0 && !(packing.checked && isState(species.startFrom));
    one["file"] = inFile ? Report(species.name + ".pos") : Report(nullptr);
    all.push_back(std::move(one));
  }
  return all;
}

Report hematocritOf(const Packing& packing) {
  const double lumen = packing.problem->lumen.container->volume(),
               fluid = packing.problem->lumen.fluidVolume();
  std::vector<HematocritConvention> kept;
  if (knowsAcceptance(*packing.problem))
    kept = hematocritConventions(packing.problem->request,
                                 tallyOf(*packing.problem, packing.kept.kept, packing.kept.excess));
  const auto ofKept = [&](const HematocritConvention& all) {
    for (const HematocritConvention& one : kept)
      if (std::string_view(one.key) == all.key) return Report(one.volume / lumen);
    return Report(nullptr);
  };
  Report all = Report::array();
  for (const HematocritConvention& one : hematocritConventions(packing.problem->request, packing.tally))
    all.push_back(
        {{"convention", one.key},
         {"text", one.text},
         {"redVolume", one.volume},
         {"ofLumen", one.volume / lumen},
         {"ofFluidNodes", packing.problem->lumen.lattice ? Report(one.volume / fluid) : Report(nullptr)},
         {"keptOfLumen", ofKept(one)}});
  return all;
}

Report certificateOf(const Certificate& certificate) {
  return {{"clean", certificate.clean()},
          {"cells", certificate.cells},
          {"pairs", certificate.pairsTested},
          {"overlapping", certificate.overlapping.size()},
          {"misplaced", certificate.misplaced.size()},
          {"selfIntersecting", certificate.selfIntersecting.size()},
          {"closer", certificate.closer},
          {"minimumGap", gapOf(certificate.minimumGap)},
          {"minimumWallGap", gapOf(certificate.minimumWallGap)},
          {"gapsMeasuredUpTo", certificate.gapsMeasuredUpTo},
          {"wallGapsMeasuredUpTo", certificate.wallGapsMeasuredUpTo}};
}

Report reportOfKept(const Packing& packing) {
  if (!knowsAcceptance(*packing.problem)) return nullptr;
  std::int64_t kept = 0;
  for (const std::int64_t n : packing.kept.kept) kept += n;
  Report all = {{"kept", kept},
                {"dropped", packing.cellCount - kept},
                {"loadedBy", packing.kept.loading == Loading::plugIn ? "plug-in" : ".pos files"},
                {"asExpected", packing.kept.asExpected()}};
  all["reasons"] = Report::array();
  for (const auto& [reason, cells] : packing.kept.reasons)
    all["reasons"].push_back({{"reason", reason}, {"cells", cells}});
  return all;
}

Report profileOf(const Profile& profile, const std::vector<CellSpecies>& species) {
  Report all = {
      {"begin", profile.begin}, {"width", profile.width}, {"lumen", profile.lumen}, {"red", profile.red}};
  all["species"] = Report::array();
  for (std::size_t s = 0; s < species.size(); ++s)
    all["species"].push_back(
        {{"name", species[s].name}, {"fraction", profile.fraction[s]}, {"error", profile.error[s]}});
  return all;
}

/// What a profile asks for, in the layers of the profile that was measured: volume fractions per species,
/// null for those that may be at any depth. Pre: there is a profile
Report askedOf(const Profile& measured, const Problem& problem) {
  Report all = Report::array();
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    Report fractions = nullptr;
    if (problem.layout.profile->species[s].isAsked()) {
      fractions = Report::array();
      for (int i = 0; i < measured.layers(); ++i)
        fractions.push_back(
            problem.layout.profile->askedAt(problem.layout.profile->species[s], measured.middle(i)));
    }
    all.push_back({{"name", problem.species[s].name}, {"fraction", std::move(fractions)}});
  }
  return {{"source", problem.layout.profile->source}, {"species", std::move(all)}};
}

Report reportOfMeasures(const PackingMeasures& measures, const Problem& problem) {
  Report all;
  all["pointsPerCell"] = measures.pointsPerCell;
  all["lumenPoints"] = measures.lumenPoints;
  all["leftOut"] = measures.leftOut;
  all["wall"] = nullptr;
  if (measures.wall) {
    all["wall"] = profileOf(*measures.wall, problem.species);
    all["wall"]["asked"] = problem.layout.profile ? askedOf(*measures.wall, problem) : Report(nullptr);
    Report& layer = all["wall"]["cellFreeLayer"];
    layer = Report::array();
    for (const double share : {0.05, 0.5}) {
      const auto thickness = layerBelow(*measures.wall, share);
      layer.push_back({{"share", share}, {"thickness", thickness ? Report(*thickness) : Report(nullptr)}});
    }
  }
  for (int k = 0; k < 3; ++k)
    all["axial"][std::string(1, "xyz"[k])] = profileOf(measures.axial[k], problem.species);
  all["gaps"] = Report::array();
  all["orientation"] = Report::array();
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    const GapHistogram& gaps = measures.gaps[s];
    const bool any = gaps.minimum != 0.0 || gaps.mean != 0.0;
    all["gaps"].push_back({{"name", problem.species[s].name},
                           {"width", gaps.width},
                           {"counts", gaps.counts},
                           {"beyond", gaps.beyond},
                           {"minimum", any ? Report(gaps.minimum) : Report(nullptr)},
                           {"mean", any ? Report(gaps.mean) : Report(nullptr)},
                           {"median", any ? Report(gaps.median) : Report(nullptr)}});
    const OrientationOrder& order = measures.orientation[s];
    Report tensor = Report::array();
    for (int row = 0; row < 3; ++row) tensor.push_back(coordinatesOf(order.tensor.row(row)));
    const bool none = order.cells == 0;
    all["orientation"].push_back({{"name", problem.species[s].name},
                                  {"cells", order.cells},
                                  {"nematic", none ? Report(nullptr) : Report(order.nematic())},
                                  {"eigenvalues", none ? Report(nullptr) : coordinatesOf(order.eigenvalues)},
                                  {"director", none ? Report(nullptr) : coordinatesOf(order.director)},
                                  {"cosines", order.cosines},
                                  {"tensor", none ? Report(nullptr) : std::move(tensor)}});
  }
  return all;
}

Report statisticsOf(const Statistics& s) {
  Report all = {{"blocks", s.blocks}, {"sweeps", s.sweeps}, {"repairs", s.repairs}, {"search", s.searching}};
  all["growth"] = nullptr;
  all["escape"] = Report::array();
  if (s.engine) all.update(Report::parse(s.engine->json()));
  return all;
}

/// The packing that was repeated, if there is one: the source of `statistics` for one that was repeated.
Report repeatedOf(const std::shared_ptr<const Packing>& before) {
  if (!before) return nullptr;
  const std::optional<double>& hematocrit = before->problem->hematocrit;
  return {{"times", before->problem->request.tiles},
          {"boxSize", coordinatesOf(*before->problem->request.boxSize)},
          {"cells", before->cellCount},
          {"hematocrit", hematocrit ? Report(*hematocrit) : Report(nullptr)},
          {"certificate", certificateOf(before->certificate)},
          {"statistics", statisticsOf(before->statistics)}};
}

Report timesOf(const Packing& packing) {
  const Statistics& s = packing.statistics;
  return {{"ranks", packing.ranks().size()}, {"threads", packing.problem->team.count()},
          {"wall", packing.times.wall},      {"cpu", packing.times.cpu},
          {"placement", s.placementSeconds}, {"relaxation", s.relaxationSeconds},
          {"growth", s.engineSeconds},       {"certificate", s.certificateSeconds}};
}

/// Of one of several realisations: its number, and the folders of its neighbours.
Report realisationOf(const OutputRequest& output) {
  const std::int64_t i = output.realisation, all = output.realisationsOfAll;
  if (i == 0) return nullptr;
  const auto folder = [&](std::int64_t number) {
    return number < 1 || number > all ? Report(nullptr) : Report(realisationFolder(number, all));
  };
  return {{"number", i}, {"of", all}, {"previous", folder(i - 1)}, {"next", folder(i + 1)}};
}

Report reportOfDeformed(const DeformedCells& of) {
  const auto values = [](const Deformation& one) {
    return Report{{"force", one.force},
                  {"volume", one.volume},
                  {"area", one.area},
                  {"triangle", one.triangle},
                  {"edge", one.edge}};
  };
  return {{"cells", of.cells}, {"largest", values(of.most)}, {"median", values(of.median)}};
}

Report reportOfDeformations(const std::optional<Deformations>& all) {
  if (!all) return nullptr;
  Report report = reportOfDeformed(*all);
  report["species"] = Report::array();
  for (const auto& [name, cells] : all->species) {
    Report one = {{"name", name}};
    one.update(reportOfDeformed(cells));
    report["species"].push_back(std::move(one));
  }
  return report;
}

const char* outcomeOf(const Packing& packing) {
  if (packing.checked) return "checked";
  return packing.outcome == Outcome::certified ? "certified" : "bestEffort";
}

}  // namespace

Report makeReport(const Packing& packing, const PackingMeasures& measures) {
  Report all;
  all["schema"] = "packMesh-report";
  all["schemaVersion"] = reportVersion;
  all["program"] = {{"name", "packMesh"}, {"version", version()}, {"commit", gitHash()}};
  const Request& request = packing.problem->request;
  all["command"] = request.words.empty() && request.asked ? wordsOf(*request.asked) : request.words;
  all["outcome"] = outcomeOf(packing);
  all["realisation"] = realisationOf(packing.output);
  all["configuration"] = configurationOf(*packing.problem, packing.output, packing.packed.clearances);
  all["lumen"] = lumenOf(*packing.problem);
  all["species"] = speciesOf(packing);
  all["hematocrit"] = hematocritOf(packing);
  all["certificate"] = certificateOf(packing.certificate);
  all["hemocell"] = reportOfKept(packing);
  all["deformation"] = reportOfDeformations(packing.deformations);
  all["measures"] = reportOfMeasures(measures, *packing.problem);
  all["statistics"] = statisticsOf(packing.statistics);
  all["repeated"] = repeatedOf(packing.before);
  all["times"] = timesOf(packing);
  return all;
}

std::filesystem::path reportJson(const OutputRequest& output) {
  return std::filesystem::path(*output.reportFile).replace_extension(".json");
}

std::string jsonText(const Report& report) {
  // File names need not be UTF-8: invalid bytes are replaced.
  return report.dump(1, ' ', false, Report::error_handler_t::replace) + "\n";
}

}  // namespace packmesh::hemocell
