// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/code_facts.h"

#include <fmt/format.h>

#include <algorithm>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/settings/value_specs.h"

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
  return fmt::format("state it by <species name=\"{0}\" minimumDistanceFromSolid=\"...\"/> or " +
                         named("minimum-distance-from-solid") + " {0} d",
                     name);
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
                          named("pre-inlet-slice") + ", " + named("pre-inlet-range") + " state it)",
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

}  // namespace packmesh::hemocell
