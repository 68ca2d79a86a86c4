// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/session/session.h"

#include <fmt/format.h>

#include <sstream>
#include <string>
#include <utility>

#include "hemocell_adapter/base/duration.h"
#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/output/requested_outputs.h"
#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/problem/plan_profile.h"
#include "hemocell_adapter/problem/tiling.h"
#include "hemocell_adapter/session/attempts.h"
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
std::string fixedText(const Problem& problem, const PackingResult& result) {
  std::int64_t fixed = 0;
  for (const CellSpecies& species : problem.species) fixed += std::int64_t(species.fixed.size());
  const std::int64_t missing = problem.mostCells() - result.cellCount;
  if (fixed == 0 || missing <= 0) return {};
  return fmt::format("; {} cell{} fixed, and no place was found for {} further cell{}", fixed,
                     fixed == 1 ? " is" : "s are", missing, missing == 1 ? "" : "s");
}

/// Why there is nothing to hand out if not all cells could be packed.
std::string failureText(const Problem& problem, const PackingResult& result, const Tally& tally,
                        const Delivery& delivery) {
  const Statistics& done = result.statistics;
  const bool begun = done.effort() > 0;
  if (result.cellCount == 0 && !begun && problem.request.maxSeconds > 0.0)
    return outOfTimeText(problem.request.maxSeconds, delivery);
  LumenSample sample(problem);
  const Forecast forecast = forecastOf(problem, sample);
  return reachedText(problem, result, tally) + fixedText(problem, result) +
         (result.cellCount == 0
              ? fmt::format("; not even one cell could be packed; {}", delivery.nothing)
              : fmt::format("; {} ({} {})", delivery.nothing, named("best-effort"), delivery.bestEffort)) +
         (forecast.effectiveFraction > Forecast::easy ? columnsInstead(problem) : "") + ". " +
         roomText(problem, forecast, sample);
}

Counted counted(const Problem& problem, const PackingResult& result) {
  Counted counted;
  counted.parts = result.counts;
  problem.ranks.sum(counted.parts);
  std::vector<std::int64_t> counts = countsOf(problem, result.cells);
  problem.ranks.sum(counts);
  counted.tally = tallyOf(problem, std::move(counts), excessVolumes(problem, result.cells));
  return counted;
}

/// @throws AgreedFailure unless all cells are packed, or those that are suffice
void requireEnough(const Problem& problem, const PackingResult& result, const Tally& tally,
                   const Delivery& delivery) {
  if (result.outcome != Outcome::outOfReach) return;
  if (!problem.request.bestEffort || result.cellCount == 0)
    throw AgreedFailure({ExitCode::outOfReach, failureText(problem, result, tally, delivery)});
  log::warning(
      fmt::format("{}; {} ({})", reachedText(problem, result, tally), delivery.fewer, named("best-effort")));
}

/// @throws AgreedFailure if the certificate is not clean and complete, or if HemoCell would delete cells of a
/// packing of which it keeps all
void requireVerified(const PackingResult& result, const Kept& kept, const Delivery& delivery) {
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

Packing Session::pack(const std::shared_ptr<const Problem>& problem, const OutputRequest& output) {
  together(ranks_, [&] { requireMemory(problem->mostCells(), ranks_); });
  makeStateFolder(output, ranks_);
  Attempts attempts(*problem, output, hooks_);
  Attempts::Found packing = attempts.withRoom(timer_);
  stateSaved_ = attempts.saved();
  stateSavedOnce_ = attempts.savedAny();
  if (packing.result.outcome == Outcome::interrupted ||
      ranks_.any(hooks_.interrupted && hooks_.interrupted())) {
    if (packing.state && savesCheckpoints(problem->request, output))  // it has just ended
      stateSaved_ = saveAsCheckpoint(*problem, output, {packing.packed, *packing.state});
    throwInterrupted(output);
  }
  const bool repeats = problem->request.isTiled() && isEnough(*problem, packing.result);
  Packing done;
  if (repeats) {
    done.problem = problem;
    done.packed = std::move(packing.packed);
    done.result = std::move(packing.result);
    done = repeatedInTiles(std::move(done), packing.state.has_value());
  } else {
    done = verified(problem, std::move(packing.packed), std::move(packing.result));
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

Packing Session::verified(std::shared_ptr<const Problem> problem, PackedParts packed,
                          PackingResult result) const {
  Packing done;
  done.problem = std::move(problem);
  done.packed = std::move(packed);
  done.result = std::move(result);
  done.cells = counted(*done.problem, done.result);
  const Tally& tally = done.cells.tally;
  requireEnough(*done.problem, done.result, tally, delivery_);
  done.kept = delivery_.countedLater
                  ? Kept{Loading::plugIn, tally.counts, excessVolumes(*done.problem, done.result.cells), {}}
                  : keptOf(*done.problem, done.result.cells);
  requireVerified(done.result, done.kept, delivery_);
  return done;
}

Packing Session::repeatedInTiles(Packing before, bool withState) const {
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
  Packing done = verified(big, big->atDemanded, std::move(result));
  done.state = std::move(end);
  done.before = std::make_shared<const Packing>(std::move(before));
  return done;
}

Kept keptOf(const Problem& problem, const std::vector<PlacedCell>& cells) {
  Kept own;
  own.loading = loadingOf(problem, cells);
  own.kept.assign(problem.species.size(), 0);
  own.excess.assign(problem.species.size(), 0.0);
  if (!knowsAcceptance(problem)) return own;
  std::vector<char> isKept(cells.size(), true);
  forEachVerdict(problem, cells, own.loading,
                 [&](std::size_t i, const std::optional<std::string>& violation) {
                   isKept[i] = !violation;
                   if (violation) {
                     countReason(own, *violation, 1);
                   } else {
                     ++own.kept[cells[i].species];
                   }
                 });
  std::string text;
  for (const auto& [reason, count] : own.reasons) text += fmt::format("{} {}\n", count, reason);
  const std::vector<char> all = problem.ranks.gatherAll(std::vector<char>(text.begin(), text.end()));
  Kept kept;
  kept.loading = own.loading;
  kept.kept = std::move(own.kept);
  problem.ranks.sum(kept.kept);
  kept.excess = excessVolumes(problem, cells, [&](std::size_t i) { return isKept[i]; });
  std::istringstream reasons(std::string(all.begin(), all.end()));
  std::int64_t count = 0;
  std::string reason;
  while (reasons >> count && reasons.ignore() && std::getline(reasons, reason))
    countReason(kept, reason, count);
  return kept;
}

std::optional<ResultState> resultStateOf(const Packing& packing) {
  if (!packing.state) return {};
  return ResultState{packing.packed, *packing.state};
}

Finished finishedOf(const Packing& packing, const OutputRequest& output) {
  Finished done{*packing.problem,    output,      packing.packed.clearances, packing.result,
                packing.cells.tally, packing.kept};
  if (packing.before) done.repeated.emplace(Repeated{*packing.before->problem, packing.before->result});
  return done;
}

void logSummary(const Packing& packing) {
  for (const std::string& line : footLines(*packing.problem, packing.packed.clearances, packing.cells.tally,
                                           packing.result.certificate, packing.kept, packing.times))
    log::info(line);
  const std::vector<Part>& parts = packing.packed.parts;
  for (const std::string& line : bloodLines(*packing.problem, parts, packing.cells.tally.counts,
                                            deformedCounts(*packing.problem, packing.result.cells)))
    log::info(line);
  for (const std::string& line : regionLines(*packing.problem, parts, packing.cells.parts)) log::info(line);
  if (!packing.problem->layout.profile) return;
  for (const std::string& line :
       profileLines(*packing.problem, reachedProfile(*packing.problem, packing.result.cells)))
    log::info(line);
}

}  // namespace packmesh::hemocell
