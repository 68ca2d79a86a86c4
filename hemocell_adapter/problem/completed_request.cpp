// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/completed_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/hemocell/units.h"
#include "hemocell_adapter/problem/choose_species.h"
#include "hemocell_adapter/problem/code_facts.h"
#include "hemocell_adapter/problem/realisation_folders.h"
#include "hemocell_adapter/settings/request_json.h"
#include "hemocell_adapter/settings/settings_table.h"
#include "packMesh/core/input_file.h"

namespace packmesh::hemocell {
namespace {

/// Whether ends are periodic: a box from the command line is packed with cells that HemoCell keeps; under the
/// name packCells it is periodic, as there. A running system is periodic where it says so. Empty: as the
/// case.
std::optional<bool> choosePeriodicEnds(const Request& request, const Case* simulation) {
  if (request.periodicEnds) return request.periodicEnds;
  if (simulation && simulation->running) return true;
  if (request.boxSize && !(request.container && request.container->lumen))
    return request.packCellsConventions && !request.keepAll;
  return {};
}

const char* nameOf(Method::Kind method) {
  return method == Method::cat ? "cat" : "relaxation";
}

/// Settings that have no effect are refused, not ignored.
void checkApplicability(const Request& request, const Case* simulation) {
  const bool meshLumen = request.container && request.container->lumen &&
                         request.container->lumen->kind == SolidRequest::Kind::mesh;
  if (request.container && request.container->lumen && request.container->lumen->openAxis && !meshLumen) {
    throw UsageError(fmt::format("{} is for {}; a cylinder is open or closed by {}", heading("open-axis"),
                                 named("vessel"), named("ends")));
  }
  if (meshLumen && request.container->lumen->file.empty()) {
    throw UsageError(fmt::format("{} needs a {}", heading("open-axis"), named("vessel")));
  }
  for (const Setting& setting : settingsTable()) {
    const std::string key = setting.key();
    if (!setting.method || *setting.method == request.method || !request.states(key)) continue;
    if (setting.isFlag() && setting.get(request) == Value(false)) continue;
    if (request.originOf(key)->isSection())
      refuseStated(request, key, fmt::format("it is for <method> {}", nameOf(*setting.method)));
    throw UsageError(
        fmt::format("{} is for {}", whereStated(request, key), named("method", nameOf(*setting.method))));
  }
  if (request.method == Method::cat && !hasCat())
    refuseStated(request, "method", "this packMesh was built without 'cat' (CMake: -DPACKMESH_CAT=ON)");
  const bool ownBody = request.container && request.container->lumen;
  const bool boxLumen = ownBody ? request.container->lumen->kind == SolidRequest::Kind::box
                                : !simulation || !simulation->domain.geometry || request.container;
  if (request.walls && !request.walls->empty() && !boxLumen)
    refuseStated(request, "walls", "walls are chosen for boxes only; the surface of this lumen is its wall");
  if (request.states("tile") &&
      (!request.boxSize || request.container || !request.periodicEnds.value_or(false)))
    throw UsageError(fmt::format("{} is for periodic boxes: {} {}", heading("tile"), named("box"),
                                 named("ends", "periodic")));
  if (request.seed + std::uint64_t(request.realisations - 1) >
      std::uint64_t(std::numeric_limits<std::int64_t>::max()))
    throw UsageError(heading("realisations") + ": the last of the seeds would be larger than a seed may be");
  if (request.inColumns && request.boxSize && !ownBody && !request.periodicEnds.value_or(false))
    throw InputError(fmt::format("columns ({}, <order>) take a box that is periodic along all axes: {} {}",
                                 named("order"), named("box"), named("ends", "periodic")));
  if (request.largestClearance && request.cat.usesReserve())
    throw UsageError(named("clearance", "max") + ": it is not searched for with " + named("escape"));
  if (request.keepAll && ownBody)
    throw UsageError(fmt::format("{} is for boxes: {}", heading("keep-all"), named("box")));
  if (request.periodicEnds.value_or(false) && request.keepAll) {
    throw UsageError(fmt::format("{} excludes {}: HemoCell deletes every cell that crosses a periodic face",
                                 named("ends", "periodic"), named("keep-all")));
  }
}

/// Valid settings that are probably unintended.
void warnOfUnits(const Request& request, const Case* simulation, std::vector<std::string>& warnings) {
  const std::string where = simulation ? simulation->domain.dxWhere : heading("dx");
  if (simulation || request.states("dx"))
    if (const auto warning = spacingWarning(request.dx, where)) warnings.push_back(*warning);
  std::error_code ignored;
  if (simulation && simulation->domain.geometry && request.container && request.container->lumen &&
      std::filesystem::is_regular_file(*simulation->domain.geometry, ignored))
    warnings.push_back(
        fmt::format("{} replaces the <geometry> of {}, {}: right only where the case builds its lumen in C++ "
                    "and does not "
                    "read that file",
                    request.container->lumen->where, simulation->file.string(),
                    simulation->domain.geometry->filename().string()));
}

/// Of a hematocrit and a discharge hematocrit there is one, after overriding. Until the lumen is known, the
/// discharge hematocrit stands for that of the lumen.
std::optional<double> statedHematocrit(const Request& request) {
  if (!request.dischargeHematocrit) return request.hematocrit;
  if (request.hematocrit) {
    if (const Origin& from = *request.originOf("hematocrit"); from.isSection())
      throw InputError(from.place + " and <dischargeHematocrit> exclude each other");
    throw UsageError(
        fmt::format("{} and {} exclude each other", named("hematocrit"), named("discharge-hematocrit")));
  }
  return request.dischargeHematocrit;
}

/// The case; of a run that continues, which names a file in the working directory, that may also be the
/// folder of a realisation. @throws InputError if it is neither there nor in the parent folder
std::filesystem::path caseFileOf(const Request& asked) {
  const std::filesystem::path& file = *asked.config;
  const bool ofState = asked.restart && asked.originOf("config")->kind == Origin::Kind::state;
  if (isThere(file) || !ofState) return file;
  if (const auto place = placeInSeries(*asked.restart, {}); place && isThere(place->seriesFolder / file))
    return place->seriesFolder / file;
  throw InputError(
      fmt::format("{}: no such file; the run of {} was started in another folder; restart it there",
                  file.string(), asked.restart->string()));
}

/// What packing and checking have in common: the request of a case or of none, overridden by a front end.
CompletedRequest complete(const Request& asked, std::shared_ptr<const Case> running) {
  requireConsistent(asked);
  CompletedRequest completed;
  completed.simulation = std::move(running);
  if (!completed.simulation && asked.config)
    completed.simulation = std::make_shared<const Case>(readCase(caseFileOf(asked)));
  const Case* const simulation = completed.simulation.get();
  completed.request = overridden(simulation ? simulation->packing : Request(), asked);
  completed.request.asked = std::make_shared<const Request>(asked);
  completed.warnings = asked.remarks;
  Request& request = completed.request;
  SpeciesOfStates withStates = speciesWithStates(request);
  request.species = std::move(withStates.species);
  completed.deformed = withStates.deformed;
  request.hematocrit = statedHematocrit(request);
  request.periodicEnds = choosePeriodicEnds(request, simulation);
  if (simulation) request.dx = simulation->domain.dx;
  warnOfUnits(request, simulation, completed.warnings);
  if (request.packCellsConventions && !request.redCellVolume) request.redCellVolume = packCellsRedCellVolume;
  checkApplicability(request, simulation);
  if (!simulation || !simulation->running)
    completed.preInlet = choosePreInlet(request, simulation, completed.warnings);
  if (request.ignoredScale)
    completed.warnings.push_back(named("scale") + " is ignored: there is no neighbour grid to tune");
  return completed;
}

}  // namespace

CompletedRequest requestToPack(const Request& asked, std::shared_ptr<const Case> running) {
  CompletedRequest completed = complete(asked, std::move(running));
  SpeciesToPack chosen = chooseSpecies(completed.request, completed.simulation.get(), completed.warnings);
  completed.request.species = std::move(chosen.species);
  completed.request.hematocrit = chosen.hematocrit;
  return completed;
}

CompletedRequest requestToCheck(const Request& asked) {
  return complete(asked, nullptr);
}

}  // namespace packmesh::hemocell
