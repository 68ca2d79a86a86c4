// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/session/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/base/duration.h"
#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/output/deformation.h"
#include "hemocell_adapter/output/requested_outputs.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/counts.h"
#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/problem/plan_profile.h"
#include "hemocell_adapter/problem/softened.h"
#include "hemocell_adapter/problem/tiling.h"
#include "hemocell_adapter/session/attempts.h"
#include "hemocell_adapter/session/examination.h"
#include "hemocell_adapter/session/memory.h"
#include "packMesh/core/poll_scope.h"
#include "packMesh/packing/pack.h"

namespace packmesh::hemocell {
namespace {

std::string outOfTimeText(double maxSeconds, const Delivery& delivery) {
  return fmt::format("the time limit of {} was reached before packing began; {}", durationText(maxSeconds),
                     delivery.nothing);
}

/// What fixed cells have to do with it: "; 149 cells are fixed, and no place was found for 1 further cell".
std::string fixedText(const Packing& packing) {
  std::int64_t fixed = 0;
  for (const CellSpecies& species : packing.problem->species) fixed += std::int64_t(species.fixed.size());
  const std::int64_t missing = packing.problem->mostCells() - packing.result.cellCount;
  if (fixed == 0 || missing <= 0) return {};
  return fmt::format("; {} cell{} fixed, and no place was found for {} further cell{}", fixed,
                     fixed == 1 ? " is" : "s are", missing, missing == 1 ? "" : "s");
}

/// Why there is nothing to hand out if not all cells could be packed.
std::string failureText(const Packing& packing, const Delivery& delivery, LumenSample& sample) {
  const Problem& problem = *packing.problem;
  const PackingResult& result = packing.result;
  const bool begun = result.statistics.effort() > 0;
  if (result.cellCount == 0 && !begun && problem.request.maxSeconds > 0.0)
    return outOfTimeText(problem.request.maxSeconds, delivery);
  const Forecast forecast = forecastOf(problem, sample);
  return reachedText(packing) + fixedText(packing) +
         (result.cellCount == 0
              ? fmt::format("; not even one cell could be packed; {}", delivery.nothing)
              : fmt::format("; {} ({} {})", delivery.nothing, named("best-effort"), delivery.bestEffort)) +
         (forecast.effectiveFraction > Forecast::easy ? denserInstead(problem) : softInstead(problem)) +
         ". " + roomText(problem, forecast, sample);
}

/// A result with the numbers of its cells on all ranks. All ranks call.
Packing countCells(std::shared_ptr<const Problem> problem, const OutputRequest& output, PackedParts packed,
                   PackingResult result) {
  Packing packing;
  packing.problem = std::move(problem);
  packing.output = output;
  packing.packed = std::move(packed);
  packing.result = std::move(result);
  const Problem& of = *packing.problem;
  packing.partCounts = packing.result.counts;
  of.ranks.sum(packing.partCounts);
  std::vector<std::int64_t> counts = countsOf(of, packing.result.cells);
  of.ranks.sum(counts);
  packing.tally = tallyOf(of, std::move(counts), excessVolumes(of, packing.result.cells));
  return packing;
}

/// @throws AgreedFailure unless all cells are packed, or those that are suffice
void requireEnough(const Packing& packing, const Delivery& delivery, LumenSample& sample) {
  if (packing.result.outcome != Outcome::outOfReach) return;
  if (!packing.problem->request.bestEffort || packing.result.cellCount == 0)
    throw AgreedFailure({ExitCode::outOfReach, failureText(packing, delivery, sample)});
  log::warning(fmt::format("{}; {} ({})", reachedText(packing), delivery.fewer, named("best-effort")));
}

/// @throws AgreedFailure if the certificate is not clean and complete, or if HemoCell would delete cells of a
/// packing of which it keeps all
void requireVerified(const Packing& packing, const Delivery& delivery) {
  const PackingResult& result = packing.result;
  const Kept& kept = packing.kept;
  const bool complete = result.certificate.cells == result.cellCount;
  if (result.certificate.clean() && complete && kept.asExpected()) return;
  throw AgreedFailure(
      {ExitCode::internal,
       fmt::format("the packing failed verification ({} of {} cells examined, {} overlapping pairs, {} "
                   "cells misplaced, {} self-intersecting, HemoCell would delete some: {}); {}. This is an "
                   "internal error; please report "
                   "it with the command",
                   result.certificate.cells, result.cellCount, result.certificate.overlapping.size(),
                   result.certificate.misplaced.size(), result.certificate.selfIntersecting.size(),
                   kept.asExpected() ? "no" : kept.reasons.front().first, delivery.nothing)});
}

/// A problem of the cells that could be packed, with the numbers of those that were requested.
std::shared_ptr<const Problem> asRequested(const Problem& problem, const Problem& requested) {
  std::vector<std::int64_t> counts;
  for (const CellSpecies& species : requested.species) counts.push_back(species.count);
  auto made = std::make_shared<Problem>(problem);
  made->species = withCounts(std::move(made->species), counts);
  return made;
}

/// Whether a result will be handed out.
bool isEnough(const Problem& problem, const PackingResult& result) {
  return result.outcome != Outcome::outOfReach || (problem.request.bestEffort && result.cellCount > 0);
}

}  // namespace

std::function<void()> endOfPreparation(double maxSeconds, const Delivery& delivery,
                                       std::function<bool()> interrupted) {
  return [maxSeconds, delivery, asked = std::move(interrupted), timer = std::make_shared<const Timer>()] {
    if (asked && asked())
      throw AgreedFailure({ExitCode::interrupted, fmt::format("interrupted: {}", delivery.nothing)});
    if (maxSeconds > 0.0 && timer->wall() > maxSeconds)
      throw AgreedFailure({ExitCode::outOfReach, outOfTimeText(maxSeconds, delivery)});
  };
}

std::shared_ptr<const Problem> Session::prepare(const CompletedRequest& completed) {
  std::shared_ptr<const Problem> problem;
  together(ranks_, [&] {
    const PollScope scope(endOfPreparation(completed.request.maxSeconds, delivery_, hooks_.interrupted));
    problem = std::make_shared<const Problem>(problemToPack(completed, ranks_));
  });
  tell(problem->notices);
  if (problem->layout.profile && !completed.request.dryRun && !completed.request.validate)
    problem = correctByPilots(std::move(problem));
  if (completed.request.isTiled()) together(ranks_, [&] { requireTileable(*problem); });
  return problem;
}

/// Packs quickly with the clearances demanded, to see how the cells of a profile arrange themselves.
std::shared_ptr<const Problem> Session::correctByPilots(std::shared_ptr<const Problem> problem) const {
  constexpr int rounds = 2;
  constexpr std::int64_t sweeps = 600;
  const double most = problem->request.maxSeconds;
  for (int round = 0; round < rounds; ++round) {
    PackingProblem pilot = packingProblemOf(*problem, problem->atDemanded, [&] {
      return (hooks_.interrupted && hooks_.interrupted()) || (most > 0.0 && timer_.wall() > most);
    });
    pilot.execution.limits.maxSweeps = std::min(pilot.execution.limits.maxSweeps, sweeps);
    pilot.execution.limits.fewerCells = false;
    const PackingResult packed = packmesh::pack(pilot);
    if (packed.outcome != Outcome::certified) break;
    problem = std::make_shared<const Problem>(withCorrectedProfile(*problem, packed));
  }
  return problem;
}

Session::Ready Session::withSoftCells(const std::shared_ptr<const Problem>& problem,
                                      const OutputRequest& output) {
  ProgressLog progressLog(*problem, sampleOf(problem));
  Softened soft = softened(
      *problem, hooks_.interrupted, [&](const Progress& progress) { hooks_.tell(progress, progressLog); },
      [&] { return ranks_.max(timer_.wall()); });
  if (ranks_.any(hooks_.interrupted && hooks_.interrupted())) throwInterrupted(output);
  const Request& request = problem->request;
  if (!soft.problem)
    throw AgreedFailure(
        {ExitCode::outOfReach,
         fmt::format("soft cells could not be packed within the limits{}: {}; {}. Fewer cells are easier",
                     request.maxSeconds > 0.0 ? fmt::format(" ({})", durationText(request.maxSeconds)) : "",
                     soft.failure, delivery_.nothing)});
  tell(soft.notices);
  for (const std::string& line : soft.lines) log::info(line);
  return {std::make_shared<const Problem>(std::move(*soft.problem)), soft.fewer ? soft.failure : ""};
}

std::optional<Attempts::Found> Session::undeformed(const std::shared_ptr<const Problem>& requested,
                                                   OutputRequest output) {
  constexpr std::int64_t mostSweeps = 10000;
  constexpr double shareOfTime = 0.5;
  LumenSample& sample = sampleOf(requested);
  if (forecastOf(*requested, sample).effectiveFraction > Forecast::possible) return {};
  Problem rigid = *requested;
  Request& request = rigid.request;
  request.soft = false;
  request.maxSeconds *= shareOfTime;
  request.maxIterations = std::min(mostSweeps, request.maxIterations.value_or(mostSweeps));
  request.origins.erase("stateFile");  // nothing continues from a checkpoint of these
  output.checkpointEvery = 0.0;
  Attempts attempts(rigid, output, sample, hooks_);
  Attempts::Found found = attempts.withRoom(timer_, false);
  if (found.result.outcome == Outcome::interrupted || ranks_.any(hooks_.interrupted && hooks_.interrupted()))
    throwInterrupted(output);
  if (found.result.outcome != Outcome::certified || found.result.cellCount == 0) return {};
  return found;
}

Packing Session::pack(const std::shared_ptr<const Problem>& requested, const OutputRequest& output) {
  together(ranks_, [&] { requireMemory(requested->mostCells(), ranks_); });
  makeStateFolder(output, ranks_);
  Ready ready{requested, ""};
  std::optional<Attempts::Found> found;
  if (requested->request.softIfNeeded) {
    found = undeformed(requested, output);
    log::info(found ? "Undeformed cells could be packed: none are soft"
                    : "Undeformed cells cannot be packed as requested: cells are soft");
  }
  if (!found) {
    if (requested->request.soft) ready = withSoftCells(requested, output);
    Attempts attempts(*ready.problem, output, sampleOf(ready.problem), hooks_);
    found = attempts.withRoom(timer_);
    stateSaved_ = attempts.saved();
    stateSavedOnce_ = attempts.savedAny();
  }
  Attempts::Found& packing = *found;
  std::shared_ptr<const Problem> problem = ready.problem;
  if (packing.result.outcome == Outcome::interrupted ||
      ranks_.any(hooks_.interrupted && hooks_.interrupted())) {
    if (packing.state && savesCheckpoints(problem->request, output))  // it has just ended
      stateSaved_ = saveAsCheckpoint(*problem, output, {packing.packed, *packing.state});
    throwInterrupted(output);
  }
  if (!ready.whyFewer.empty()) {
    packing.result.outcome = Outcome::outOfReach;
    problem = asRequested(*problem, *requested);
  }
  const bool repeats = problem->request.isTiled() && isEnough(*problem, packing.result);
  Packing done = countCells(problem, output, std::move(packing.packed), std::move(packing.result));
  done.whyFewer = std::move(ready.whyFewer);
  if (repeats) {
    done = repeatInTiles(std::move(done), packing.state.has_value());
  } else {
    done = verify(std::move(done));
    done.state = std::move(packing.state);
  }
  done.times = {timer_.cpu(), timer_.wall()};
  return done;
}

void Session::throwInterrupted(const OutputRequest& output) const {
  throw AgreedFailure(
      {ExitCode::interrupted,
       stateSaved_ ? fmt::format("interrupted: {}{}", delivery_.continueFrom, checkpointFile(output).string())
                   : fmt::format("interrupted: {}", delivery_.interrupted)});
}

LumenSample& Session::sampleOf(const std::shared_ptr<const Problem>& problem) {
  if (sampled_ != problem) {
    sample_.emplace(*problem);
    sampled_ = problem;
  }
  return *sample_;
}

Packing Session::verify(Packing packing) {
  requireEnough(packing, delivery_, sampleOf(packing.problem));
  const Problem& problem = *packing.problem;
  const std::vector<PlacedCell>& cells = packing.result.cells;
  packing.kept = delivery_.countedLater
                     ? Kept{Loading::plugIn, packing.tally.counts, excessVolumes(problem, cells), {}, {}}
                     : findKept(problem, cells, loadingOf(problem, cells));
  requireVerified(packing, delivery_);
  packing.deformations = deformationsOf(packing);
  return packing;
}

Packing Session::repeatInTiles(Packing before, bool withState) {
  const Problem& problem = *before.problem;
  std::shared_ptr<const Problem> big;
  together(ranks_, [&] {
    big = std::make_shared<const Problem>(tiledProblem(problem, before.packed.clearances, before.result));
  });
  tell(big->notices);
  const auto& times = problem.request.tiles;
  log::info(
      fmt::format("Repeated {} x {} x {} times: {}", times[0], times[1], times[2], lumenLines(*big).front()));
  PackingProblem packing = packingProblemOf(*big, big->atDemanded, hooks_.interrupted);
  std::optional<PackingState> end;
  if (withState)
    packing.checkpoints = Checkpoints{{}, [&](const PackingState& state) {
                                        if (isFinished(state, ranks_)) end = state;
                                      }};
  PackingResult result = packmesh::pack(packing);
  nameBySpecies(big->atDemanded, result);
  if (result.outcome == Outcome::interrupted)
    throw AgreedFailure({ExitCode::interrupted, fmt::format("interrupted: {}", delivery_.interrupted)});
  Packing done = verify(countCells(big, before.output, big->atDemanded, std::move(result)));
  done.state = std::move(end);
  done.before = std::make_shared<const Packing>(std::move(before));
  return done;
}

void logSummary(const Packing& packing) {
  for (const std::string& line : footLines(packing)) log::info(line);
  if (packing.deformations)
    for (const std::string& line : deformationLines(*packing.deformations)) log::info(line);
  const Problem& problem = *packing.problem;
  for (const std::string& line : bloodLines(packing, deformedCounts(problem, packing.result.cells)))
    log::info(line);
  for (const std::string& line : regionLines(packing)) log::info(line);
  if (!problem.layout.profile) return;
  for (const std::string& line : profileLines(problem, reachedProfile(problem, packing.result.cells)))
    log::info(line);
}

}  // namespace packmesh::hemocell
