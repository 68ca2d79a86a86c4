// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/session/clearance_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/cat/state_frames.h"
#include "hemocell_adapter/output/output_plan.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/make_problem.h"
#include "hemocell_adapter/problem/parts.h"
#include "packMesh/core/error.h"
#include "packMesh/packing/pack.h"
#include "packMesh/packing/problem_digest.h"
#include "packMesh/packing/state_file.h"
#include "packMesh/soft/soft_packing.h"

namespace packmesh::hemocell {
namespace {

/// Interval between two lines [s]: on a terminal; otherwise if verbose; otherwise.
constexpr double terminalPause = 0.2, verbosePause = 1.0, plainPause = 10.0;

double pauseNow() {
  if (log::isTerminal()) return terminalPause;
  return log::level() == log::Level::verbose ? verbosePause : plainPause;
}

}  // namespace

ProgressLog::ProgressLog(const Problem& problem, LumenSample& sample, const SearchLimits& limits)
    : problem_(problem), sample_(sample), limits_(limits), hematocrit_(0.0) {
  for (const CellSpecies& species : problem.species)
    if (species.redCell) hematocrit_ += double(species.count) * species.meanVolume;
  hematocrit_ /= problem.referenceVolume();
}

double ProgressLog::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
}

std::optional<double> ProgressLog::remaining(const Progress& progress, double seconds) {
  if (progress.left > 0) {
    if (firstSweep_ < 0 || progress.sweep < lastSweep_) {
      firstSweep_ = progress.sweep;
      firstSeconds_ = seconds;
    }
    lastSweep_ = progress.sweep;
    if (seconds < 1.0 || progress.sweep == firstSweep_) return {};
    return double(progress.left) * (seconds - firstSeconds_) / double(progress.sweep - firstSweep_);
  }
  if (seconds < 1.0) return {};
  const std::optional<double> expected = expectedSeconds();
  if (!expected || *expected <= seconds + 1.0) return {};
  return *expected - seconds;
}

void ProgressLog::operator()(const Progress& progress) {
  const double now = seconds();
  if (progress.left > 0) static_cast<void>(remaining(progress, now));  // counts from the first one on
  if (now - last_ < pauseNow()) return;
  last_ = now;
  if (log::isTerminal())
    log::status(text(progress, now));
  else
    log::info(text(progress, now));
}

std::optional<double> ProgressLog::expectedSeconds() {
  if (problem_.request.method != Method::relaxation || limits_.soft) return {};
  if (!forecast_) forecast_ = forecastOf(problem_, sample_);
  if (!forecast_->seconds) return {};
  return *forecast_->seconds / (problem_.ranks.size() * problem_.team.count());
}

std::string ProgressLog::text(const Progress& progress, double seconds) {
  const bool grows = progress.stage == "growth", soft = progress.stage == softCellsStage;
  std::string line =
      fmt::format("{}: {} {}, hematocrit {:.3f}", progress.stage, grows || soft ? "iteration" : "sweep",
                  progress.sweep, hematocrit_ * std::pow(progress.scale, 3.0));
  if (soft)
    line += progress.scale < 1.0 ? fmt::format(" at scale {:.2f}", progress.scale) : ", coming to rest";
  else if (grows)
    line += fmt::format(" at scale {:.2f}, {} cells below it", progress.scale, progress.unresolved);
  else
    line += fmt::format(", {} contacts, deepest by {:.4f} µm", progress.unresolved, progress.worstOverlap);
  line += "; " + durationText(std::floor(seconds));
  // The search for fewer cells may take the same time again (Limits::maxSeconds).
  if (const double limit = limits_.maxSeconds; limit > 0.0)
    line += fmt::format(" of {} at most", durationText(seconds > limit ? 2.0 * limit : limit));
  if (const auto left = remaining(progress, seconds))
    line += fmt::format(", {} {} left", soft ? "at least" : "about", durationText(std::ceil(*left)));
  return line;
}

namespace {

/// Ranks on other nodes may find different files under the same names.
void requireSameOnAllRanks(const PackingProblem& problem) {
  const Communicator& ranks = problem.execution.communicator;
  if (ranks.alone()) return;
  const std::string own = digestOf(problem), first = ranks.broadcast(own, 0);
  together(ranks, [&] {
    if (own != first)
      throw InputError(
          fmt::format("rank {} has a different problem than rank 0 (lumen, cells, counts, clearances "
                      "or seed): do all nodes see the same files?",
                      ranks.rank()));
  });
}

/// False if the clearances alone make it impossible: lumen too small, fixed cells closer to each other. The
/// same on all ranks.
bool isPossible(const PackingProblem& problem) {
  try {
    validate(problem);
  } catch (const InputError&) {
    return false;
  }
  return true;
}

/// Prints statistics of packing, in detail.
void tellEffort(const Statistics& statistics, const Communicator& ranks) {
  for (const std::string& line : effortLines(statistics)) log::detail(line);
  if (!ranks.alone()) {
    const double each = 1.0 / double(std::max<std::int64_t>(1, statistics.effort()));
    log::detail(fmt::format(
        "Rank 0 sent {:.1f} messages and {:.1f} kB per {}", each * double(ranks.traffic().messages),
        1e-3 * each * double(ranks.traffic().bytes), statistics.engine ? "iteration" : "sweep"));
  }
  if (!statistics.engine && statistics.blocks < ranks.size())
    log::info(fmt::format("Note: {} block{} of cells for {} ranks; {} had nothing to do", statistics.blocks,
                          statistics.blocks == 1 ? "" : "s", ranks.size(), ranks.size() - statistics.blocks));
}

/// Warns of cells at the wall, which are soon lost.
void warnOfNoRoom(const std::vector<Clearances>& levels, const PackingResult& packing,
                  const Problem& problem) {
  if (packing.outcome != Outcome::certified || !problem.lumen.solidWalls || !problem.lumen.container->wall())
    return;
  if (levels.size() == 1) {  // stated, or the cells stay where they are
    const double gap = packing.certificate.minimumWallGap;
    if (triesMoreClearance(problem.request) && problem.request.choosesWallClearance() &&
        gap < leastWallRoom(problem.request))
      log::warning(fmt::format(
          "the cells stay where they were, the nearest {:.4f} µm from the wall: HemoCell silently deletes a "
          "cell as soon as it moves onto a wall node. {}, or less, moves them away",
          gap, named("wall-clearance", fmt::format("{:.6g}", problem.request.dx))));
    return;
  }
  const bool room = packing.wallClearance > levels.back().wall || packing.clearance > levels.back().membranes;
  if (room) return;
  log::warning(fmt::format(
      "at this hematocrit no gap between the cells and the wall could be kept ({:.6g} µm were tried): "
      "HemoCell silently deletes a cell as soon as it moves onto a wall node. Fewer cells are lost at a "
      "lower hematocrit",
      levels.front().wall));
}

}  // namespace

ClearanceSearch::ClearanceSearch(std::shared_ptr<const Problem> problem, const OutputRequest& output,
                                 LumenSample& sample, const Hooks& hooks,
                                 const std::optional<SearchLimits>& limits, bool isContinued)
    : shared_(std::move(problem)),
      problem_(*shared_),
      output_(output),
      limits_(limits.value_or(problem_.request)),
      progress_(problem_, sample, limits_),
      hooks_(hooks),
      isContinued_(isContinued),
      last_(problem_.atDemanded) {}

const PartsToPack& ClearanceSearch::partsWith(const Clearances& clearances) {
  const auto have = [&](const PartsToPack& parts) {
    return parts.clearances.membranes == clearances.membranes && parts.clearances.wall == clearances.wall;
  };
  if (!have(last_))
    last_ = have(problem_.atDemanded) ? problem_.atDemanded : partsAt(problem_, problem_.layout, clearances);
  return last_;
}

std::optional<PackingResult> ClearanceSearch::packAt(const Clearances& clearances,
                                                     const AttemptLimits& limits) {
  const Request& request = problem_.request;
  PackingProblem packing =
      packingProblemOf(problem_, partsWith(clearances), hooks_.interrupted,
                       [this](const Progress& progress) { hooks_.tell(progress, progress_); });
  if (!begun_) requireSameOnAllRanks(packing);
  if (!limits.fewerCells && !isPossible(packing)) return {};
  packing.execution.limits.maxSeconds = limits.maxSeconds;
  if (limits_.maxIterations) packing.execution.limits.maxSweeps = *limits_.maxIterations;
  if (limits.maxSweeps > 0)
    packing.execution.limits.maxSweeps = std::min(limits.maxSweeps, packing.execution.limits.maxSweeps);
  packing.execution.limits.sweepsForFew = limits.sweepsForFew;
  packing.execution.limits.fewerCells = limits.fewerCells;
  packing.execution.limits.someCloser = limits.someCloser;
  std::optional<StateFrames> frames;
  if (const auto series = requestedFrames(output_)) {
    frames.emplace(packing, *series);
    packing.execution.observe = [&frames](const std::vector<PlacedCell>& own) { frames->add(own); };
  }
  StateFiles states(request, output_, packing, isContinued_);
  packing.checkpoints = states.checkpoints();
  if (request.restart && isContinued_ && !begun_) packing.resume = stateToContinue(*request.restart, packing);
  begun_ = true;
  PackingResult result = packmesh::pack(packing);
  nameBySpecies(last_, result);
  if (frames && hooks_.convertsFrames) frames->convert();
  saved_ = states.saved().value_or(saved_);  // an attempt that saved nothing leaves that of the last one
  savedAny_ = savedAny_ || states.savedAny();
  if (states.end()) end_ = std::move(states.end());
  if (result.outcome == Outcome::outOfReach && !limits.fewerCells)
    log::detail(fmt::format(
        "Clearances of {:.6g} µm between membranes and {:.6g} µm to the wall: no packing in {} {}",
        clearances.membranes, clearances.wall, result.statistics.effort(), result.statistics.unit()));
  return result;
}

Packing ClearanceSearch::withClearances(const Timer& timer) {
  const Communicator& ranks = problem_.ranks;
  const std::vector<Clearances> levels = clearanceLevels(problem_);
  Packing packing(packWithClearances(
      problem_.request, limits_, levels, firstLevel(levels), problem_.mostCells(),
      [&] { return ranks.max(timer.wall()); },
      [&](const Clearances& clearances, const AttemptLimits& limits) { return packAt(clearances, limits); }));
  const bool ended = packing.outcome == Outcome::interrupted || ranks.any(isInterrupted());
  if (!ended) {
    tellEffort(packing.statistics, ranks);
    if (!limits_.soft) warnOfNoRoom(levels, packing, problem_);  // said of soft cells when they are made
  }
  // Not the clearances of the last attempt: that may have failed after one that succeeded.
  packing.packed = partsWith({packing.clearance, packing.wallClearance});
  packing.problem = shared_;
  packing.output = output_;
  packing.state = std::move(end_);
  const bool promised = output_.stateFile && packing.cellCount > 0 &&
                        (packing.outcome == Outcome::certified || problem_.request.bestEffort);
  if (!ended && promised && !packing.state)
    throw std::logic_error("the packing has ended without the state that is to be written");
  return packing;
}

std::size_t ClearanceSearch::firstLevel(const std::vector<Clearances>& levels) {
  const auto& restart = problem_.request.restart;
  if (!restart || !isContinued_ || levels.size() == 1) return 0;
  std::string digest;
  together(problem_.ranks, [&] { digest = readStateHead(*restart).digest; });
  const auto belongs = [&](const Clearances& level) {
    return digestOf(packingProblemOf(problem_, partsWith(level))) == digest;
  };
  std::size_t level = 0;
  while (level + 1 < levels.size() && !belongs(levels[level])) ++level;
  return level;
}

}  // namespace packmesh::hemocell
