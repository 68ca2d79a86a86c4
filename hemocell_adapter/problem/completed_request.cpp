// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/completed_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/hemocell/units.h"
#include "hemocell_adapter/problem/realisation_folders.h"
#include "hemocell_adapter/problem/species_plans.h"
#include "hemocell_adapter/settings/request_json.h"
#include "hemocell_adapter/settings/settings_table.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/input_file.h"

namespace packmesh::hemocell {
namespace {

/// A distance as stored by HemoCell: in whole micrometres.
int truncated(double distance) {
  return static_cast<int>(distance);
}

bool isDistance(double value) {
  const ValueSpec spec = specs::distanceFromSolid();
  return value >= spec.low && value <= spec.high;
}

/// "1 µm", "0.5 µm (0 as HemoCell truncates it)".
std::string distanceText(double distance) {
  if (distance == truncated(distance)) return fmt::format("{:.15g} µm", distance);
  return fmt::format("{:.15g} µm ({} as HemoCell truncates it)", distance, truncated(distance));
}

std::string originText(const std::string& where, double distance) {
  if (distance == truncated(distance)) return where;
  return fmt::format("{}: {:.15g}, which HemoCell truncates to whole µm", where, distance);
}

std::string howToState(const std::string& name) {
  return fmt::format("give it by <species name=\"{}\" minimumDistanceFromSolid=\"...\"/> or {}", name,
                     named("minimum-distance-from-solid", name + " d"));
}

/// The calls that set the distance of one species.
struct Found {
  const DistanceCall* largest = nullptr;
  const DistanceCall* other = nullptr;  ///< of another distance
};

Found callsFor(const std::string& name, const CaseSource& source) {
  Found found;
  const auto distance = [](const DistanceCall* call) { return truncated(*call->distance); };
  for (const DistanceCall& call : source.distances) {
    if (call.name != name || !call.distance || !isDistance(*call.distance)) continue;
    if (!found.largest) {
      found.largest = &call;
    } else if (distance(&call) > distance(found.largest)) {
      found.other = found.largest;
      found.largest = &call;
    } else if (!found.other && distance(&call) < distance(found.largest)) {
      found.other = &call;
    }
  }
  return found;
}

/// One line for each call that does not determine the distance of a species that must be known.
void warnOfUnknownCalls(const CaseSource& source, const std::vector<std::string>& unstated,
                        std::vector<std::string>& warnings) {
  for (const DistanceCall& call : source.distances) {
    if (unstated.empty() || (call.name && call.distance && isDistance(*call.distance))) continue;
    if (call.name && std::find(unstated.begin(), unstated.end(), *call.name) == unstated.end()) continue;
    const char* what = call.distance && isDistance(*call.distance) ? "which cell this is for"
                       : call.name                                 ? "the distance"
                                                                   : "what this sets";
    warnings.push_back(fmt::format("{}: {}: {} cannot be determined from the code; {}", call.where, call.text,
                                   what, howToState(call.name.value_or(unstated.front()))));
  }
}

}  // namespace

std::vector<SpeciesPlan> withDistancesFromSolid(const Case& simulation, std::vector<SpeciesPlan> all,
                                                std::vector<std::string>& warnings) {
  if (simulation.running) {
    for (SpeciesPlan& species : all) {
      species.minimumDistanceFromSolid = simulation.running->cell(species.name)->minimumDistanceFromSolid;
      species.distanceFromSolidOrigin = "of the running HemoCell";
    }
    return all;
  }
  const CaseSource& source = simulation.source;
  std::vector<std::string> unstated;
  for (const SpeciesPlan& species : all)
    if (!species.statedDistanceFromSolid) unstated.push_back(species.name);
  if (!unstated.empty()) {
    for (const std::string& file : source.unread) warnings.push_back(file);
    if (source.files.empty())
      warnings.push_back(fmt::format(
          "no C++ file beside {}: the minimum distance from solid of {} is assumed to be 0 µm. Cases that "
          "call setInitialMinimumDistanceFromSolid (most of HemoCell's do, with 1) lose cells at the wall "
          "then; {}",
          simulation.file.filename().string(), fmt::join(unstated, ", "), howToState(unstated.front())));
  }
  warnOfUnknownCalls(source, unstated, warnings);
  const bool allRead = !source.files.empty() && source.unread.empty();
  const bool anyUnnamed = std::any_of(source.distances.begin(), source.distances.end(),
                                      [](const DistanceCall& call) { return !call.name; });
  for (SpeciesPlan& species : all) {
    const Found found = callsFor(species.name, source);
    const int inCode = found.largest ? truncated(*found.largest->distance) : 0;
    if (species.statedDistanceFromSolid) {
      const double stated = *species.statedDistanceFromSolid;
      species.minimumDistanceFromSolid = truncated(stated);
      species.distanceFromSolidOrigin = originText("stated", stated);
      if (found.largest && inCode != truncated(stated))
        warnings.push_back(
            fmt::format("the minimum distance from solid of {} is stated to be {}, but {} says {}: the "
                        "stated one is taken",
                        species.name, distanceText(stated), found.largest->where,
                        distanceText(*found.largest->distance)));
      continue;
    }
    species.minimumDistanceFromSolid = inCode;
    if (found.largest) {
      species.distanceFromSolidOrigin = originText(found.largest->where, *found.largest->distance);
      if (found.other)
        warnings.push_back(fmt::format(
            "{} and {} set different minimum distances from solid for {}: the larger one, {}, is taken; {}",
            found.other->where, found.largest->where, species.name, distanceText(*found.largest->distance),
            howToState(species.name)));
    } else {
      const bool known = allRead && !anyUnnamed &&
                         std::none_of(source.distances.begin(), source.distances.end(),
                                      [&](const DistanceCall& call) { return call.name == species.name; });
      species.distanceFromSolidOrigin =
          !known ? "assumed" : fmt::format("not set in {}", fmt::join(source.files, ", "));
    }
  }
  return all;
}

namespace {

/// The call that says the inlet's direction, if all calls say the same; with a slice if they agree on it.
std::optional<PreInletCall> callOf(const CaseSource& source) {
  std::optional<PreInletCall> one;
  for (const PreInletCall& call : source.preInlets) {
    if (!call.direction || (one && one->direction != call.direction)) return {};
    if (!one)
      one = call;
    else if (one->slice != call.slice)
      one->slice.reset();
  }
  return one;
}

/// The inlet is defined in C++ code, and is not guessed.
[[noreturn]] void refuseUnknownPreInlet(const Case& simulation) {
  std::string calls;
  for (const PreInletCall& call : simulation.source.preInlets)
    calls += fmt::format(" {}: {}.", call.where, call.text);
  throw InputError(fmt::format(
      "{}: the case has a <preInlet>: HemoCell then reads the .pos files for the inlet only. Its position "
      "is defined in the case's C++ code, of which only autoPreinletFromBoundary(Direction::Xpos) is "
      "read.{} Find preInletFromSlice(Direction::Xpos, slice) there, and specify the direction by " +
          named("pre-inlet", "Xpos") +
          " or <packing><preInlet> Xpos </preInlet>, and the plane by <preInletSlice> where "
          "the slice is not the outermost plane with fluid. Or describe the inlet in <packing><container>, "
          "with its low corner at the origin. The plug-in needs none of this",
      simulation.file.string(), calls));
}

/// The parts of the plane that are stated. @throws InputError if one is along the inlet
std::vector<NodeRange> statedRanges(const Request& request, int axis) {
  std::vector<NodeRange> ranges = request.preInletRanges;
  std::sort(ranges.begin(), ranges.end(),
            [](const NodeRange& a, const NodeRange& b) { return a.axis < b.axis; });
  for (const NodeRange& range : ranges)
    if (range.axis == axis)
      throw InputError(fmt::format(
          named("pre-inlet-range") + " {}: the inlet is along {}; its ranges are those of the other two axes",
          toString(range), "xyz"[axis]));
  return ranges;
}

}  // namespace

std::optional<PreInletPlace> choosePreInlet(const Request& request, const Case* simulation,
                                            std::vector<std::string>& warnings) {
  const bool detailed = request.preInletSlice || !request.preInletRanges.empty();
  const bool needed = simulation && simulation->hasPreInlet && !request.container;
  if (!request.preInlet && !needed) {
    if (detailed)
      throw UsageError("slice and range of a pre-inlet need its direction: " + named("pre-inlet", "Xpos"));
    return {};
  }
  if (!needed && !(simulation && simulation->hasPreInlet && simulation->preInletLength))
    throw InputError(named("pre-inlet") +
                     " is for cases whose config.xml has <preInlet><parameters><lengthN>");
  const std::optional<PreInletCall> call = callOf(simulation->source);
  if (!request.preInlet && !call && detailed)
    throw UsageError("slice and range of a pre-inlet need its direction: " + named("pre-inlet", "Xpos"));
  if (!request.preInlet && (!call || (!call->slice && !request.preInletSlice)))
    refuseUnknownPreInlet(*simulation);
  if (!simulation->preInletLength)
    throw InputError(fmt::format("{}: <preInlet> has no <parameters><lengthN>", simulation->file.string()));
  if (!simulation->domain.geometry || request.container)
    throw InputError(simulation->file.string() + ": a pre-inlet (" + named("pre-inlet") +
                     ") is packed in cases with a <geometry>; describe another inlet in "
                     "<packing><container>, with its low corner at the origin");
  PreInletPlace place = PreInletPlace::named(request.preInlet ? *request.preInlet : *call->direction);
  const bool same = call && lowered(*call->direction) == lowered(request.preInlet.value_or(*call->direction));
  if (call && !same)
    warnings.push_back(
        fmt::format("the pre-inlet is stated to be {}, but {} says Direction::{}: the stated one is taken",
                    *request.preInlet, call->where, *call->direction));
  place.slice = request.preInletSlice;
  if (same && !place.slice) {
    place.slice = call->slice;
    if (!detailed) place.origin = call->where;
    if (!place.slice)
      warnings.push_back(
          fmt::format("{}: {}: slices are not read from the code; the outermost one with fluid is taken "
                      "(" +
                          named("pre-inlet-slice") + ", " + named("pre-inlet-range") + " set it)",
                      call->where, call->text));
  }
  place.ranges = statedRanges(request, place.axis);
  return place;
}

std::vector<std::string> unreadWalls(const Request& request, const Case* simulation) {
  std::vector<std::string> warnings;
  if (!simulation || simulation->running || request.container) return warnings;
  const std::string instead = "; packmesh::loadParticles() in the case knows the true ones";
  const std::string lumen = simulation->domain.geometry
                                ? "that of " + simulation->domain.geometry->filename().string()
                                : "the box of <domain>";
  if (simulation->domain.geometry && !simulation->source.walls.empty()) {
    const WallCall& call = simulation->source.walls.front();
    const std::size_t others = simulation->source.walls.size() - 1;
    warnings.push_back(fmt::format(
        "{}: {}{}: walls in boxes of nodes are not read from the code. The lumen is assumed to be {} without "
        "them{}",
        call.where, call.text, others > 0 ? fmt::format(" (and {} more)", others) : "", lumen, instead));
  }
  for (const PeriodicAxis& call : simulation->source.periodicAxes) {
    if (!call.axis) {
      warnings.push_back(fmt::format(
          "{}: {}: which axis this is cannot be determined from the code. The lumen is assumed to "
          "be {}, and its ends as stated by " +
              named("ends") + " and " + named("walls") + "{}",
          call.where, call.text, lumen, instead));
      continue;
    }
    const char name = "xyz"[*call.axis];
    const bool assumedClosed = simulation->domain.geometry
                                   ? *call.axis != 0
                                   : request.walls.value_or("").find(name) != std::string::npos;
    if (assumedClosed)
      warnings.push_back(
          fmt::format("{0}: {1}: the lumen is assumed to be {2}, which ends along {3}, and not "
                      "to be periodic along {3}{4}",
                      call.where, call.text, lumen, name, instead));
  }
  return warnings;
}

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
