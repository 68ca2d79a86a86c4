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
  const std::int64_t missing = packing.problem->mostCells() - packing.cellCount;
  if (fixed == 0 || missing <= 0) return {};
  return fmt::format("; {} cell{} fixed, and no place was found for {} further cell{}", fixed,
                     fixed == 1 ? " is" : "s are", missing, missing == 1 ? "" : "s");
}

/// Why there is nothing to hand out if not all cells could be packed.
std::string failureText(const Packing& packing, const Delivery& delivery, LumenSample& sample) {
  const Problem& problem = *packing.problem;
  const bool begun = packing.statistics.effort() > 0;
  if (packing.cellCount == 0 && !begun && problem.request.maxSeconds > 0.0)
    return outOfTimeText(problem.request.maxSeconds, delivery);
  const Forecast forecast = forecastOf(problem, sample);
  return reachedText(packing) + fixedText(packing) +
         (packing.cellCount == 0
              ? fmt::format("; not even one cell could be packed; {}", delivery.nothing)
              : fmt::format("; {} ({} {})", delivery.nothing, named("best-effort"), delivery.bestEffort)) +
         (forecast.effectiveFraction > Forecast::easy ? denserInstead(problem) : softInstead(problem)) +
         ". " + roomText(problem, forecast, sample);
}

/// Whether all cells are packed, or those that are suffice.
bool isEnough(const Packing& packing) {
  return packing.outcome != Outcome::outOfReach ||
         (packing.problem->request.bestEffort && packing.cellCount > 0);
}

/// @throws AgreedFailure unless all cells are packed, or those that are suffice
void requireEnough(const Packing& packing, const Delivery& delivery, LumenSample& sample) {
  if (!isEnough(packing)) throw AgreedFailure({ExitCode::outOfReach, failureText(packing, delivery, sample)});
  if (packing.outcome != Outcome::outOfReach) return;
  log::warning(fmt::format("{}; {} ({})", reachedText(packing), delivery.fewer, named("best-effort")));
}

/// @throws AgreedFailure if the certificate is not clean and complete, or if HemoCell would delete cells of a
/// packing of which it keeps all
void requireVerified(const Packing& packing, const Delivery& delivery) {
  const Certificate& certificate = packing.certificate;
  const Kept& kept = packing.kept;
  if (isClean(certificate, kept) && certificate.cells == packing.cellCount) return;
  throw AgreedFailure(
      {ExitCode::internal,
       fmt::format("the packing failed verification ({} of {} cells examined, {} overlapping pairs, {} "
                   "cells misplaced, {} self-intersecting, HemoCell would delete some: {}); {}. This is an "
                   "internal error; please report "
                   "it with the command",
                   certificate.cells, packing.cellCount, certificate.overlapping.size(),
                   certificate.misplaced.size(), certificate.selfIntersecting.size(),
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
  return {std::make_shared<const Problem>(std::move(*soft.problem)), soft.fewer ? soft.failure : ""};
}

std::optional<Packing> Session::undeformed(const std::shared_ptr<const Problem>& requested,
                                           OutputRequest output) {
  constexpr std::int64_t mostSweeps = 10000;
  constexpr double shareOfTime = 0.5;
  LumenSample& sample = sampleOf(requested);
  if (forecastOf(*requested, sample).effectiveFraction > Forecast::possible) return {};
  const auto rigid = std::make_shared<Problem>(*requested);
  Request& request = rigid->request;
  request.soft = false;
  request.maxSeconds *= shareOfTime;
  request.maxIterations = std::min(mostSweeps, request.maxIterations.value_or(mostSweeps));
  request.origins.erase("stateFile");  // nothing continues from a checkpoint of these
  output.checkpointEvery = 0.0;
  Attempts attempts(rigid, output, sample, hooks_);
  Packing found = attempts.withRoom(timer_, false);
  if (found.outcome == Outcome::interrupted || ranks_.any(hooks_.interrupted && hooks_.interrupted()))
    throwInterrupted(output);
  if (found.outcome != Outcome::certified || found.cellCount == 0) return {};
  found.problem = requested;
  return found;
}

Packing Session::pack(const std::shared_ptr<const Problem>& requested, const OutputRequest& output) {
  together(ranks_, [&] { requireMemory(requested->mostCells(), ranks_); });
  makeStateFolder(output, ranks_);
  std::optional<Packing> found;
  if (requested->request.softIfNeeded) {
    found = undeformed(requested, output);
    log::info(found ? "Undeformed cells could be packed: none are soft"
                    : "Undeformed cells cannot be packed as requested: cells are soft");
  }
  Ready ready{requested, ""};
  if (!found) {
    if (requested->request.soft) ready = withSoftCells(requested, output);
    Attempts attempts(ready.problem, output, sampleOf(ready.problem), hooks_);
    found = attempts.withRoom(timer_);
    stateSaved_ = attempts.saved();
    stateSavedOnce_ = attempts.savedAny();
  }
  Packing packing = std::move(*found);
  const Problem& problem = *ready.problem;
  if (packing.outcome == Outcome::interrupted || ranks_.any(hooks_.interrupted && hooks_.interrupted())) {
    if (packing.state && savesCheckpoints(problem.request, output))  // it has just ended
      stateSaved_ = saveAsCheckpoint(problem, output, {packing.packed, *packing.state});
    throwInterrupted(output);
  }
  if (!ready.whyFewer.empty()) {
    packing.outcome = Outcome::outOfReach;
    packing.problem = asRequested(problem, *requested);
  }
  packing.output = output;
  packing.whyFewer = std::move(ready.whyFewer);
  const bool repeats = problem.request.isTiled() && isEnough(packing);
  packing = countCells(std::move(packing));
  packing = repeats ? repeatInTiles(std::move(packing)) : verify(std::move(packing));
  packing.times = {timer_.cpu(), timer_.wall()};
  return packing;
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
  const std::vector<PlacedCell>& cells = packing.cells;
  packing.kept = delivery_.countedLater
                     ? Kept{Loading::plugIn, packing.tally.counts, excessVolumes(problem, cells), {}, {}}
                     : findKept(problem, cells, loadingOf(problem, cells));
  requireVerified(packing, delivery_);
  packing.deformations = deformationsOf(packing);
  return packing;
}

Packing Session::repeatInTiles(Packing before) {
  const Problem& problem = *before.problem;
  std::shared_ptr<const Problem> big;
  together(ranks_, [&] {
    big = std::make_shared<const Problem>(tiledProblem(problem, before.packed.clearances, before));
  });
  tell(big->notices);
  const auto& times = problem.request.tiles;
  log::info(
      fmt::format("Repeated {} x {} x {} times: {}", times[0], times[1], times[2], lumenLines(*big).front()));
  PackingProblem packing = packingProblemOf(*big, big->atDemanded, hooks_.interrupted);
  std::optional<PackingState> end;
  if (before.state)
    packing.checkpoints = Checkpoints{{}, [&](const PackingState& state) {
                                        if (isFinished(state, ranks_)) end = state;
                                      }};
  Packing done(packmesh::pack(packing));
  nameBySpecies(big->atDemanded, done);
  if (done.outcome == Outcome::interrupted)
    throw AgreedFailure({ExitCode::interrupted, fmt::format("interrupted: {}", delivery_.interrupted)});
  done.problem = big;
  done.output = before.output;
  done.packed = big->atDemanded;
  done.state = std::move(end);
  done = verify(countCells(std::move(done)));
  before.state.reset();
  done.before = std::make_shared<const Packing>(std::move(before));
  return done;
}

void logSummary(const Packing& packing) {
  for (const std::string& line : footLines(packing)) log::info(line);
  if (packing.deformations)
    for (const std::string& line : deformationLines(*packing.deformations)) log::info(line);
  const Problem& problem = *packing.problem;
  for (const std::string& line : bloodLines(packing, deformedCounts(problem, packing.cells))) log::info(line);
  for (const std::string& line : regionLines(packing)) log::info(line);
  if (!problem.layout.profile) return;
  for (const std::string& line : profileLines(problem, reachedProfile(problem, packing.cells)))
    log::info(line);
}

}  // namespace packmesh::hemocell
