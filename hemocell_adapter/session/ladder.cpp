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
#include "packMesh/soft/soft_engine.h"

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

std::optional<double> ProgressLog::remaining(double seconds) {
  if (seconds < 1.0) return {};
  const std::optional<double> expected = expectedSeconds();
  if (!expected || *expected <= seconds + 1.0) return {};
  return *expected - seconds;
}

void ProgressLog::operator()(const Progress& progress) {
  const double now = seconds();
  if (now - last_ < pauseNow()) return;
  last_ = now;
  if (log::isTerminal())
    log::status(text(progress, now));
  else
    log::info(text(progress, now));
}

std::optional<double> ProgressLog::expectedSeconds() {
  if (problem_.request.method != Method::relaxation || problem_.request.deforms()) return {};
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
  if (const auto left = remaining(seconds))
    line += fmt::format(", about {} left", durationText(std::ceil(*left)));
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
  const bool maySoften = problem_->request.deforms();
  StateHead head;
  together(ranks(), [&] {
    head = readStateHead(*restart);
    if (head.stage == softCellsStage && !maySoften)
      throw InputError(fmt::format("{}: is the state of soft cells ({})", restart->string(), named("soft")));
    if (head.stage == finishedStage && head.deformed && maySoften && !problem_->hasDeformed())
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
    if (rung.isSoft() && request.deforming == Deforming::asLast && whyNotDeformed_.empty() &&
        begin_ == Begin::anew)
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
  if (request.deforming == Deforming::asLast && packing.problem == problem_ &&
      packing.outcome == Outcome::certified && whyNotDeformed_.empty())
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
    return digest == digestOf(packingProblem(rung, partsOf(rung)));
  };
  std::size_t first = 0;
  while (first < last && !belongs(plan.rungs[first])) ++first;
  return first;
}

PartsToPack Ladder::partsOf(const Rung& rung) const {
  const Clearances& demanded = problem_->atDemanded.clearances;
  const bool asDemanded =
      demanded.membranes == rung.clearances.membranes && demanded.wall == rung.clearances.wall;
  return asDemanded ? problem_->atDemanded : partsAt(*problem_, problem_->layout, rung.clearances);
}

PackingProblem Ladder::packingProblem(const Rung& rung, const PartsToPack& parts) {
  PackingProblem packing =
      packingProblemOf(*problem_, parts, hooks_.interrupted,
                       [this](const Progress& progress) { hooks_.tell(progress, progress_); });
  packing.physics.smoothWalls = rung.smoothWalls;
  Limits& limits = packing.execution.limits;
  if (rung.most > 0) limits.maxSweeps = rung.most;
  limits.sweepsForFew = rung.sweepsForFew;
  limits.fewerCells = rung.fewerCells;
  limits.someCloser = rung.someCloser;
  return packing;
}

std::optional<Packing> Ladder::attempt(const Rung& rung, double seconds) {
  const PartsToPack parts = partsOf(rung);
  PackingProblem packing = packingProblem(rung, parts);
  packing.execution.limits.maxSeconds = seconds;
  if (rung.cells == Rung::Cells::probe) return probed(packing, parts);
  std::shared_ptr<const Problem> ofCells = problem_;
  if (rung.isSoft())
    packing.engine = softEngine(*problem_, parts, [&](const std::vector<Cell>& cells) {
      warnOfDeformed(rung, parts, cells);
      ofCells = std::make_shared<const Problem>(problemOfSoftCells(*problem_, parts, cells));
      return packingProblemOf(*ofCells, ofCells->atDemanded).physics;
    });
  if (!rung.fewerCells && !isPossible(packing)) return {};
  start(packing);
  StateFiles states(problem_->request, output_, packing, rung.savesStates, rung.savesFailed);
  packing.checkpoints = states.checkpoints();
  Packing packed(packWithFrames(packing));
  note(states);
  packed.problem = ofCells;
  packed.packed = ofCells == problem_ ? parts : ofCells->atDemanded;
  packed.output = output_;
  packed.state = std::move(states.end());
  packed.counts.resize(packed.packed.parts.size());
  nameBySpecies(packed.packed, packed);
  explain(rung, packed);
  // From the end of an undeformed packing a run continues; with soft cells, pack() has looked itself.
  if (!rung.isSoft() && packed.outcome != Outcome::interrupted && isInterrupted())
    interrupt(packed, rung.savesStates);
  return packed;
}

/// Packs, and writes the states of an engine that are asked for.
PackingResult Ladder::packWithFrames(PackingProblem& packing) const {
  const auto series = requestedFrames(output_);
  if (!series) return packmesh::pack(packing);
  StateFrames frames(packing, *series);
  packing.execution.observe = [&frames](const std::vector<PlacedCell>& own) { frames.add(own); };
  PackingResult packed = packmesh::pack(packing);
  if (hooks_.convertsFrames) frames.convert();
  return packed;
}

/// A packing that has just ended.
void Ladder::interrupt(Packing& packed, bool savesStates) {
  if (packed.state && savesStates && savesCheckpoints(problem_->request, output_))
    saved_ = saveAsCheckpoint(packed);
  packed.outcome = Outcome::interrupted;
}

Packing Ladder::probed(PackingProblem& packing, const PartsToPack& parts) {
  start(packing);
  const bool succeeds = canPackUndeformed(packing, softSpeciesOf(*problem_, parts));
  return nothing(isInterrupted() ? Outcome::interrupted
                 : succeeds      ? Outcome::certified
                                 : Outcome::outOfReach);
}

namespace {

/// " (2 s)" if time was short.
std::string limitText(const Packing& packed) {
  return packed.late ? fmt::format(" ({})", durationText(packed.problem->request.maxSeconds)) : "";
}

}  // namespace

/// Of a packing that is not the one requested: why, and what could be raised.
void Ladder::explain(const Rung& rung, Packing& packed) {
  const bool all = packed.outcome != Outcome::outOfReach;
  bool raises = !all;
  if (rung.isSoft()) {
    const SoftStatistics& reached = statisticsOfSoft(packed);
    const std::string why = all ? "" : failureOf(reached, softLimitsOf(problem_->request));
    if (!rung.savesFailed) whyNotWithRoom_ = why;
    whyNotDeformed_ =
        all ? "" : "soft cells could not be packed within the limits" + limitText(packed) + ": " + why;
    raises = raises && !reached.atRest;
    if (packed.cellCount == 0) packed.statistics = {};
    packed.whyFewer = whyNotDeformed_;
    if (!all && packed.cellCount > 0) packed.whyFewer += "; without those that found no room";
  } else if (!whyNotDeformed_.empty()) {
    packed.whyFewer =
        whyNotDeformed_ +
        (packed.cellCount > 0 ? "; of undeformed cells" : "; not even one undeformed cell could be packed");
  } else if (!all && !rung.fewerCells) {
    log::detail(fmt::format(
        "Clearances of {:.6g} µm between membranes and {:.6g} µm to the wall: no packing in {} {}",
        rung.clearances.membranes, rung.clearances.wall, packed.statistics.effort(),
        packed.statistics.unit()));
  }
  if (rung.savesStates)  // otherwise a restart continues from that of an earlier rung
    raise_ = !raises ? "" : packed.late ? named("max-time", "SECONDS") : named("max-iterations", "NUMBER");
  packed.raise = raise_;
}

/// Of soft cells that are packed: what they do not keep to.
void Ladder::warnOfDeformed(const Rung& rung, const PartsToPack& parts,
                            const std::vector<Cell>& cells) const {
  if (const double room = rung.lessRoomThan; room > 0.0)
    log::warning(fmt::format(
        "vertices are nearer to the wall than {:.4g} µm (0.71 dx), at which none is on a solid node: "
        "HemoCell deletes cells with a vertex on one, and a smaller dx leaves them more room{}",
        room, whyNotWithRoom_.empty() ? "" : "; that far from the wall " + whyNotWithRoom_));
  if (const auto warning = strayWarning(*problem_, parts, cells)) log::warning(*warning);
}

/// A packing without cells.
Packing Ladder::nothing(Outcome outcome) const {
  Packing packing;
  packing.outcome = outcome;
  packing.problem = problem_;
  packing.packed = problem_->atDemanded;
  packing.output = output_;
  packing.counts.assign(packing.packed.parts.size(), 0);
  return packing;
}

/// Before the first attempt: it continues from the state that there is.
void Ladder::start(PackingProblem& packing) {
  if (std::exchange(begun_, true)) return;
  requireSameOnAllRanks(packing);
  if (begin_ != Begin::anew) packing.resume = stateToContinue(*problem_->request.restart, packing);
}

/// An attempt that saved nothing leaves the state of the last one.
void Ladder::note(const StateFiles& states) {
  saved_ = states.saved().value_or(saved_);
  savedAny_ = savedAny_ || states.savedAny();
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
