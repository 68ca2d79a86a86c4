// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/run_steps.h"

#include <fmt/format.h>

#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include "hemocell_adapter/base/duration.h"
#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/base/stopped.h"
#include "hemocell_adapter/problem/build_scene.h"
#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/problem/tiling.h"
#include "packMesh/core/poll_scope.h"
#include "packMesh/packing/pack.h"

namespace packmesh::hemocell {
namespace {

std::string outOfTimeText(const Job& job, const Delivery& delivery) {
  return fmt::format("the time limit of {} was reached before packing began; {}",
                     durationText(job.maxSeconds), delivery.nothing);
}

/// Why there is nothing to hand out if not all cells could be packed.
std::string failureText(const Scene& scene, const PackingResult& result, const Tally& tally,
                        const Delivery& delivery) {
  const Statistics& done = result.statistics;
  const bool begun = done.effort() > 0;
  if (result.cellCount == 0 && !begun && scene.maxSeconds > 0.0) return outOfTimeText(scene, delivery);
  const Forecast forecast = forecastOf(scene);
  return reachedText(scene, result, tally) +
         (result.cellCount == 0 ? fmt::format("; not even one cell could be packed; {}", delivery.nothing)
                                : fmt::format("; {} ({})", delivery.nothing, delivery.bestEffort)) +
         (forecast.effectiveFraction > Forecast::easy ? columnsInstead(scene) : "") + ". " +
         roomText(scene, forecast);
}

}  // namespace

std::function<void()> endOfPreparation(const Job& job, const Timer& timer, const Delivery& delivery,
                                       std::function<bool()> interrupted) {
  return [&job, &timer, &delivery, asked = std::move(interrupted)] {
    if (asked && asked())
      throw Stopped({ExitCode::interrupted, fmt::format("interrupted: {}", delivery.nothing)});
    if (job.maxSeconds > 0.0 && timer.wall() > job.maxSeconds)
      throw Stopped({ExitCode::outOfReach, outOfTimeText(job, delivery)});
  };
}

Scene builtScene(const Job& job, const Communicator& ranks, const std::function<void()>& poll) {
  std::optional<Scene> scene;
  together(ranks, [&] {
    const PollScope scope(poll);
    scene = buildScene(job, ranks);
  });
  for (const std::string& notice : scene->notices) log::warning(notice);
  return std::move(*scene);
}

Counted counted(const Scene& scene, PackingResult& result, const Communicator& ranks) {
  Counted counted;
  counted.parts = namedBySpecies(scene, result);
  ranks.sum(counted.parts);
  std::vector<std::int64_t> counts = countsOf(scene, result.cells);
  ranks.sum(counts);
  counted.tally = tallyOf(scene, std::move(counts));
  return counted;
}

/// Of the cells of all ranks.
Kept keptOf(const Scene& scene, const std::vector<PlacedCell>& cells, const Communicator& ranks) {
  Kept own;
  own.kept.assign(scene.species.size(), 0);
  if (!knowsAcceptance(scene)) return own;
  forEachVerdict(scene, cells, [&](std::size_t i, const std::optional<std::string>& violation) {
    if (violation) {
      countReason(own, *violation, 1);
    } else {
      ++own.kept[cells[i].species];
    }
  });
  std::string text;
  for (const auto& [reason, count] : own.reasons) text += fmt::format("{} {}\n", count, reason);
  const std::vector<char> all = ranks.gatherAll(std::vector<char>(text.begin(), text.end()));
  Kept kept;
  kept.kept = std::move(own.kept);
  ranks.sum(kept.kept);
  std::istringstream reasons(std::string(all.begin(), all.end()));
  std::int64_t count = 0;
  std::string reason;
  while (reasons >> count && reasons.ignore() && std::getline(reasons, reason))
    countReason(kept, reason, count);
  return kept;
}

Verified verified(const Scene& scene, PackingResult& result, const Communicator& ranks,
                  const Delivery& delivery) {
  Verified verified{counted(scene, result, ranks), {}};
  const Tally& tally = verified.cells.tally;
  if (result.outcome == Outcome::outOfReach) {
    if (!scene.bestEffort || result.cellCount == 0)
      throw AgreedFailure({ExitCode::outOfReach, failureText(scene, result, tally, delivery)});
    log::warning(fmt::format("{}; {}", reachedText(scene, result, tally), delivery.fewer));
  }
  verified.kept = delivery.countedLater ? Kept{tally.counts, {}} : keptOf(scene, result.cells, ranks);
  const bool allKept = verified.kept.reasons.empty();
  const bool promised = scene.lumen.acceptedOnly && !scene.lumen.periodic;
  const bool complete = result.certificate.cells == result.cellCount;
  if (!result.certificate.clean() || !complete || (promised && !allKept))
    throw AgreedFailure(
        {ExitCode::internal,
         fmt::format(
             "the packing failed verification ({} of {} cells examined, {} overlapping pairs, {} "
             "cells misplaced, HemoCell would delete some: {}); {}. This is an internal error; please report "
             "it with the command",
             result.certificate.cells, result.cellCount, result.certificate.overlapping.size(),
             result.certificate.misplaced.size(), allKept ? "no" : verified.kept.reasons.front().first,
             delivery.nothing)});
  return verified;
}

RepeatedPacking repeatedInTiles(const Scene& scene, PackingResult& result, const Communicator& ranks,
                                const std::function<bool()>& interrupted) {
  namedBySpecies(scene, result);
  Scene big = builtScene(tiledJob(scene, result, ranks), ranks);
  log::info(fmt::format("Repeated {} x {} x {} times: {}", scene.tiles[0], scene.tiles[1], scene.tiles[2],
                        lumenLines(big).front()));
  PackingProblem problem = problemOf(big, interrupted, {});
  PackingResult packed = pack(problem);
  return {std::move(big), std::move(packed)};
}

void logSummary(const Scene& scene, const Counted& counted, const Certificate& certificate, const Kept& kept,
                const RunTimes& times) {
  for (const std::string& line : footLines(scene, counted.tally, certificate, kept, times)) log::info(line);
  for (const std::string& line : regionLines(scene, counted.parts)) log::info(line);
}

}  // namespace packmesh::hemocell
