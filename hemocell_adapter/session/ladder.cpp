// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/session/ladder.h"

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
#include "hemocell_adapter/problem/soft_problem.h"
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

ProgressLog::ProgressLog(const Problem& problem, LumenSample& sample)
    : problem_(problem), sample_(sample), hematocrit_(0.0) {
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
  if (problem_.request.method != Method::relaxation || problem_.request.soft) return {};
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
  if (const double limit = problem_.request.maxSeconds; limit > 0.0)
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
void warnOfNoRoom(const Packing& packing) {
  const Problem& problem = *packing.problem;
  const std::vector<Clearances> levels = clearanceLevels(problem);
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

Ladder::Ladder(std::shared_ptr<const Problem> problem, const OutputRequest& output, LumenSample& sample,
               const Hooks& hooks, const Timer& timer)
    : problem_(std::move(problem)),
      output_(output),
      sample_(sample),
      hooks_(hooks),
      timer_(timer),
      progress_(*problem_, sample),
      begin_(findBegin()) {}

Begin Ladder::findBegin() const {
  const auto& restart = problem_->request.restart;
  if (!restart) return Begin::anew;
  if (!problem_->request.soft) return Begin::undeformed;
  StateHead head;
  together(ranks(), [&] {
    head = readStateHead(*restart);
    if (head.stage == finishedStage && head.deformed && !problem_->hasDeformed())
      throw InputError(fmt::format("{}: is the result of packing soft cells; {} takes its cells",
                                   restart->string(), named("start", restart->string())));
  });
  return head.stage == softCellsStage ? Begin::soft : Begin::undeformed;
}

Packing Ladder::climb() {
  const Request& request = problem_->request;
  const Plan plan = planOf(*problem_, sample_, begin_);
  for (const std::string& line : plan.lines(request.maxSeconds > 0.0)) log::detail("Plan: " + line);
  Packing best = nothing(Outcome::outOfReach);
  for (std::size_t i = firstRung(plan); i < plan.rungs.size();) {
    const Rung& rung = plan.rungs[i];
    const bool probes = rung.cells == Rung::Cells::probe;
    if (rung.isSoft() && request.softIfNeeded && whyNotSoft_.empty() && begin_ == Begin::anew)
      log::info("Undeformed cells cannot be packed as requested: cells are soft");
    auto tried = attempt(rung, secondsOf(rung, request.maxSeconds, elapsed()));
    if (tried && tried->outcome == Outcome::interrupted) return *tried;
    const bool enough = tried && (tried->outcome == Outcome::certified || tried->cellCount > 0);
    if (tried && !probes) best = std::move(*tried);
    if (enough && !probes) break;
    i = enough ? i + 1 : rung.otherwise;
  }
  if (plan.widens && best.outcome == Outcome::certified) widen(best);
  if (best.outcome != Outcome::interrupted) finish(best);
  return best;
}

/// Tells what is known of the packing at the end.
void Ladder::finish(const Packing& packing) const {
  const Request& request = problem_->request;
  if (packing.cellCount == 0 && packing.statistics.effort() == 0) return;
  tellEffort(packing.statistics, ranks());
  if (packing.problem == problem_) warnOfNoRoom(packing);
  if (request.softIfNeeded && packing.problem == problem_ && packing.outcome == Outcome::certified &&
      whyNotSoft_.empty())
    log::info("Undeformed cells could be packed: none are soft");
  const bool promised = output_.stateFile && packing.cellCount > 0 &&
                        (packing.outcome == Outcome::certified || request.bestEffort);
  if (promised && !packing.state)
    throw std::logic_error("the packing has ended without the state that is to be written");
}

/// That to which the state of `restart` belongs; the last one of its kind if it belongs to none.
std::size_t Ladder::firstRung(const Plan& plan) {
  if (begin_ == Begin::anew) return 0;
  std::size_t last = 0;
  while (last + 1 < plan.rungs.size() && plan.rungs[last + 1].cells == plan.rungs[last].cells &&
         plan.rungs[last + 1].savesStates)
    ++last;
  if (last == 0) return 0;
  std::string digest;
  together(ranks(), [&] { digest = readStateHead(*problem_->request.restart).digest; });
  const auto belongs = [&](const Rung& rung) {
    const PartsToPack parts = partsAt(*problem_, problem_->layout, rung.clearances);
    return digest ==
           digestOf(rung.isSoft() ? softProblem(parts, rung, 0.0) : packingProblem(*problem_, parts));
  };
  std::size_t first = 0;
  while (first < last && !belongs(plan.rungs[first])) ++first;
  return first;
}

std::optional<Packing> Ladder::attempt(const Rung& rung, double seconds) {
  if (rung.isSoft()) return attemptSoft(rung, seconds);
  if (rung.cells == Rung::Cells::undeformed) return attemptUndeformed(problem_, rung, seconds);
  const PartsToPack parts = partsAt(*problem_, problem_->layout, rung.clearances);
  PackingProblem packing = softProblem(parts, rung, seconds);
  start(packing, false);
  const bool succeeds = canPackUndeformed(packing, softSpeciesOf(*problem_, parts));
  return nothing(isInterrupted() ? Outcome::interrupted
                 : succeeds      ? Outcome::certified
                                 : Outcome::outOfReach);
}

/// A packing without cells.
Packing Ladder::nothing(Outcome outcome) const {
  Packing packing;
  packing.outcome = outcome;
  packing.problem = problem_;
  packing.packed = problem_->atDemanded;
  packing.output = output_;
  packing.counts.assign(packing.packed.parts.size(), 0);
  packing.whyFewer = whyNotSoft_;
  return packing;
}

PackingProblem Ladder::packingProblem(const Problem& problem, const PartsToPack& parts) {
  return packingProblemOf(problem, parts, hooks_.interrupted,
                          [this](const Progress& progress) { hooks_.tell(progress, progress_); });
}

/// Before the first attempt: it continues from the state that there is.
void Ladder::start(PackingProblem& packing, bool soft) {
  if (std::exchange(begun_, true)) return;
  requireSameOnAllRanks(packing);
  if (begin_ != Begin::anew) packing.resume = stateToContinue(*problem_->request.restart, packing, soft);
}

/// An attempt that saved nothing leaves the state of the last one.
void Ladder::note(const StateFiles& states) {
  saved_ = states.saved().value_or(saved_);
  savedAny_ = savedAny_ || states.savedAny();
}

/// @param problem of this ladder, or of soft cells that are to be certified
std::optional<Packing> Ladder::attemptUndeformed(const std::shared_ptr<const Problem>& problem,
                                                 const Rung& rung, double seconds) {
  const Clearances& demanded = problem->atDemanded.clearances;
  const bool asDemanded =
      demanded.membranes == rung.clearances.membranes && demanded.wall == rung.clearances.wall;
  const PartsToPack parts =
      asDemanded ? problem->atDemanded : partsAt(*problem, problem->layout, rung.clearances);
  PackingProblem packing = packingProblem(*problem, parts);
  if (!rung.fewerCells && !isPossible(packing)) return {};
  Limits& limits = packing.execution.limits;
  limits.maxSeconds = seconds;
  if (rung.most > 0 || problem->request.maxIterations)
    limits.maxSweeps = rung.most > 0 ? rung.most : *problem->request.maxIterations;
  limits.sweepsForFew = rung.sweepsForFew;
  limits.fewerCells = rung.fewerCells;
  limits.someCloser = rung.someCloser;
  std::optional<StateFrames> frames;
  if (const auto series = requestedFrames(output_)) {
    frames.emplace(packing, *series);
    packing.execution.observe = [&frames](const std::vector<PlacedCell>& own) { frames->add(own); };
  }
  start(packing, false);
  StateFiles states(problem->request, output_, packing, rung.savesStates);
  packing.checkpoints = states.checkpoints();
  Packing packed(packmesh::pack(packing));
  nameBySpecies(parts, packed);
  if (frames && hooks_.convertsFrames) frames->convert();
  note(states);
  packed.problem = problem;
  packed.packed = parts;
  packed.output = output_;
  packed.state = std::move(states.end());
  if (!whyNotSoft_.empty())
    packed.whyFewer = whyNotSoft_ + (packed.cellCount > 0 ? "; of undeformed cells"
                                                          : "; not even one undeformed cell could be packed");
  if (packed.outcome == Outcome::outOfReach && !rung.fewerCells)
    log::detail(fmt::format(
        "Clearances of {:.6g} µm between membranes and {:.6g} µm to the wall: no packing in {} {}",
        rung.clearances.membranes, rung.clearances.wall, packed.statistics.effort(),
        packed.statistics.unit()));
  if (packed.outcome == Outcome::interrupted || !isInterrupted()) return packed;
  if (packed.state && rung.savesStates && savesCheckpoints(problem->request, output_))  // it has just ended
    saved_ = saveAsCheckpoint(packed);
  packed.outcome = Outcome::interrupted;
  return packed;
}

PackingProblem Ladder::softProblem(const PartsToPack& parts, const Rung& rung, double seconds) {
  PackingProblem packing = packingProblem(*problem_, parts);
  packing.physics.smoothWalls = rung.smoothWalls;
  packing.execution.limits.maxSeconds = seconds;
  return packing;
}

Packing Ladder::attemptSoft(const Rung& rung, double seconds) {
  const Problem& problem = *problem_;
  const PartsToPack parts = partsAt(problem, problem.layout, rung.clearances);
  PackingProblem packing = softProblem(parts, rung, seconds);
  start(packing, true);
  StateFiles states(problem.request, output_, packing);
  packing.checkpoints = states.checkpoints();
  const SoftLimits limits = softLimitsOf(problem.request, rung);
  const SoftPacking soft = packSoft(packing, softSpeciesOf(problem, parts), limits);
  const bool all = soft.outcome == Outcome::certified;
  bool interrupted = soft.outcome == Outcome::interrupted || isInterrupted();
  whyNotSoft_ = all || interrupted ? "" : failureOf(soft, limits);
  if (!rung.savesFailed) whyNotWithRoom_ = whyNotSoft_;
  Packing packed = nothing(soft.outcome);
  if (!interrupted && !soft.cells.empty()) {
    if (const double room = rung.lessRoomThan; room > 0.0)
      log::warning(fmt::format(
          "vertices are nearer to the wall than {:.4g} µm (0.71 dx), at which none is on a solid node: "
          "HemoCell deletes cells with a vertex on one, and a smaller dx leaves them more room{}",
          room, whyNotWithRoom_.empty() ? "" : "; that far from the wall " + whyNotWithRoom_));
    if (const auto warning = strayWarning(problem, parts, soft.cells)) log::warning(*warning);
    packed = certified(std::make_shared<const Problem>(problemOfSoftCells(problem, parts, soft.cells)));
    interrupted = packed.outcome == Outcome::interrupted;
  }
  if (interrupted && soft.end) states.checkpoints()->save(*soft.end);  // it has just ended
  note(states);
  if (interrupted) packed.outcome = Outcome::interrupted;
  return packed;
}

/// The certificate of soft cells, from which nothing continues: it takes less time than they. If some of them
/// found no room, the others are fewer cells.
Packing Ladder::certified(const std::shared_ptr<const Problem>& softCells) {
  Rung rung;
  rung.clearances = softCells->demanded;
  rung.fewerCells = true;
  rung.savesStates = false;
  const double limit = problem_->request.maxSeconds;
  Packing packed = *attemptUndeformed(softCells, rung, secondsOf(rung, limit, elapsed()));
  if (!whyNotSoft_.empty()) packed.whyFewer = whyNotSoft_ + "; without those that found no room";
  return packed;
}

/// There are no states: they are of one attempt each.
void Ladder::widen(Packing& best) {
  const double limit = problem_->request.maxSeconds > 0.0 ? problem_->request.maxSeconds : defaultSearch;
  for (double failed = 0.0, left = limit - elapsed(); left > 0.0; left = limit - elapsed()) {
    const std::optional<double> wider = widerClearance(best.clearance, failed);
    if (!wider) return;
    std::optional<Packing> tried = attempt(widerRung(*problem_, {*wider, best.wallClearance}), left);
    if (tried && tried->outcome == Outcome::interrupted) {
      best.outcome = Outcome::interrupted;
      return;
    }
    if (tried && tried->outcome == Outcome::certified)
      best = std::move(*tried);
    else
      failed = *wider;
  }
}

}  // namespace packmesh::hemocell
