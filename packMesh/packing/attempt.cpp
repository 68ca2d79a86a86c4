// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/attempt.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <utility>

#include "packMesh/analysis/cell_measures.h"
#include "packMesh/certificate/certifier.h"
#include "packMesh/core/timer.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/packing/cell_placing.h"
#include "packMesh/relaxation/schedule.h"

namespace packmesh {
namespace {

/// Cells that are stuck are relocated if they are at most so many, or one of so many up to so many, which
/// have at most so many contacts each; and only in the first sweeps of a run.
constexpr std::int64_t fewStuck = 8, oneStuckOf = 8, mostStuck = 500, contactsOfStuck = 6,
                       sweepsWithRelocation = 5000;

/// One of so many cells may be closer than required where Limits::someCloser permits it; it is tried in so
/// many rounds of so many sweeps.
constexpr std::int64_t oneCloserOf = 20, closerRounds = 12, closerSweeps = 200;

/// Of what a certificate has found, that which meets nothing.
Certificate onlyTooNear(Certificate found) {
  const auto meets = [](const auto& one) { return !(one.gap > 0.0); };
  found.overlapping.erase(std::remove_if(found.overlapping.begin(), found.overlapping.end(), meets),
                          found.overlapping.end());
  found.misplaced.erase(std::remove_if(found.misplaced.begin(), found.misplaced.end(), meets),
                        found.misplaced.end());
  return found;
}

/// Removes what is permitted to cells that may be closer. @return how many of them are
std::int64_t permit(const std::set<std::int64_t>& closer, Certificate& certificate) {
  std::set<std::int64_t> are;
  const auto take = [&](std::initializer_list<std::int64_t> cells, double gap) {
    const auto some =
        std::find_if(cells.begin(), cells.end(), [&](std::int64_t cell) { return closer.count(cell) > 0; });
    if (gap > 0.0 && some != cells.end()) are.insert(*some);
    return gap > 0.0 && some != cells.end();
  };
  auto& pairs = certificate.overlapping;
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                             [&](const OverlappingPair& pair) {
                               return take({pair.first, pair.second}, pair.gap);
                             }),
              pairs.end());
  auto& cells = certificate.misplaced;
  cells.erase(std::remove_if(cells.begin(), cells.end(),
                             [&](const MisplacedCell& cell) { return take({cell.cell}, cell.gap); }),
              cells.end());
  return std::int64_t(are.size());
}

bool isUnmoved(const BodyState& before, const BodyState& after) {
  return before.id == after.id && before.species == after.species && before.shape == after.shape &&
         before.scale == after.scale && before.position == after.position &&
         before.orientation.coeffs() == after.orientation.coeffs();
}

}  // namespace

Attempt::Attempt(const PackingProblem& problem, RunControl& control)
    : problem_(problem),
      control_(control),
      cells_(problem.physics.cellCount()),
      shares_(cells_, problem.execution.communicator),
      repairs_(problem.physics),
      written_(problem) {}

bool Attempt::certifyAll(std::int64_t sweeps) {
  if (std::holds_alternative<GivenUp>(end_)) return false;
  const std::int64_t most = std::min(sweeps, problem_.execution.limits.maxSweeps);
  if (!placed_) {
    begin();
    if (engine_ && !engineDone(most)) return false;
    if (!placed_) return false;
    keepState();
    if (control_.interrupted()) return false;
    if (startsClean()) return true;
    if (placed_->at.fewer) return certified();
  }
  while (!control_.outOfTime()) {
    if (placed_->at.stage == Stage::relaxation && !relaxed(most)) break;
    if (certified()) return true;
  }
  const bool suspended = most < problem_.execution.limits.maxSweeps && placed_->relaxation.sweeps() >= most;
  if (suspended || control_.interrupted()) return false;
  end_ = GivenUp();
  return cleanByChance() || certifiedWithSomeCloser();
}

PackingResult Attempt::takeResult() {
  PackingResult result;
  if (auto* const certified = std::get_if<PackingResult>(&end_); certified && !control_.interrupted()) {
    result = std::move(*certified);
  } else {
    result.outcome = control_.interrupted() ? Outcome::interrupted : Outcome::outOfReach;
  }
  result.clearance = problem_.physics.clearance;
  result.wallClearance = problem_.physics.wallClearance;
  endRelaxation();
  result.statistics = std::move(statistics_);
  return result;
}

/// Takes its numbers from the relaxation, which then frees its memory.
void Attempt::endRelaxation() {
  if (!placed_) return;
  statistics_.blocks = placed_->relaxation.blockCount();
  statistics_.sweeps = placed_->relaxation.sweeps();
  placed_.reset();
}

/// Places the cells, or takes them from the state to resume.
void Attempt::begin() {
  if (engine_) return;
  const Engine* const engine = problem_.engine.get();
  if (problem_.resume && !(engine && problem_.resume->position.stage == Stage::engine)) {
    const EngineState* const past = problem_.resume->engine.get();
    if (engine) statistics_.engine = engine->statistics(past ? past->iterations() : 0);
    resume(*problem_.resume);
  } else if (engine) {
    engine_ = engine->begin(problem_, control_, statistics_, [this] { keepState(); });
    if (engine_->hasBegun()) keepState();
  } else {
    const Timer watch(statistics_.placementSeconds);
    if (std::optional<std::vector<Body>> bodies =
            placedCells(problem_.physics, problem_.execution, shares_, control_))
      place(std::move(*bodies), {});
  }
}

void Attempt::resume(const PackingState& state) {
  const RunPosition at = state.position.fewer ? RunPosition{Stage::certificate, true, 0, {}} : state.position;
  statistics_.repairs = state.repairs;
  repairs_.restore(state);
  shares_ = IdShares(std::max(cells_, state.cellCount), problem_.execution.communicator);
  place(bodiesOf(state.cells), at, state.relaxation);
}

void Attempt::place(std::vector<Body> bodies, const RunPosition& at, const RelaxationState& state) {
  const RunPosition next = at;  // may be that of the cells before
  placed_.emplace(problem_, std::move(bodies), state, next);
}

/// Whether the engine has brought all cells to full size; if so, they are ready for the certificate.
bool Attempt::engineDone(std::int64_t iterations) {
  const bool done = engine_->run(iterations) && !problem_.engine->deforms();
  if (done)
    takeFromEngine();
  else if (!control_.interrupted() && (engine_->ended() || iterations >= problem_.execution.limits.maxSweeps))
    end_ = GivenUp();
  return done;
}

std::optional<Physics> Attempt::deformed() {
  if (!engine_ || control_.interrupted()) return {};
  return engine_->take().deformed;
}

/// Replaces the stage of the engine by a relaxation of its cells of full size.
void Attempt::takeFromEngine() {
  std::vector<Body> cells = engine_->take().cells;
  std::int64_t last = 0;  // it may have added cells
  for (const Body& cell : cells) last = std::max(last, cell.id + 1);
  last = -problem_.execution.communicator.min(-last);
  shares_ = IdShares(std::max(cells_, last), problem_.execution.communicator);
  place(std::move(cells), {Stage::certificate, false, 0, {}});
}

/// If initial poses are given for all cells and they form a valid packing, it is kept unchanged.
bool Attempt::startsClean() {
  const bool whole = std::all_of(problem_.physics.species.begin(), problem_.physics.species.end(),
                                 [](const Species& s) { return s.placed() >= s.count; });
  if (!whole || engine_ || placed_->relaxation.sweeps() > 0 || placed_->relaxation.cellCount() == 0)
    return false;
  return cleanByChance();
}

/// Whether the current cells pass the certificate; if so, they are delivered. Stops at the first violation.
bool Attempt::cleanByChance() {
  const Timer watch(statistics_.certificateSeconds);
  placed_->relaxation.dropLists();
  CertificateInput input = inputNow();
  input.upToFirstFault = true;
  const Certificate found = ofAllRanks(certify(input), written_.ids(), problem_.execution.communicator);
  written_ = WrittenCells(problem_);
  if (found.clean()) deliver(found);
  return found.clean();
}

/// The cells as they would be written now. Pre: the lists of the relaxation were dropped.
CertificateInput Attempt::inputNow() {
  written_.take(placed_->relaxation);
  CertificateInput input = written_.certificateInput();
  input.stop = [this] { return control_.outOfTimeHere(); };
  return input;
}

/// Stores the state that is saved if the run ends before the next call. Pre: there are cells; the relaxation
/// is about to rebuild its lists.
void Attempt::keepState() {
  if (!problem_.checkpoints) return;
  PackingState& kept = kept_.emplace();
  if (placed_) {
    kept.position = placed_->at;
    kept.repairs = statistics_.repairs;
    kept.relaxation = placed_->relaxation.state();
    repairs_.store(kept);
    kept.cellCount = placed_->relaxation.cellCount();
    kept.cells = placed_->relaxation.unsortedStates();
    if (statistics_.engine)
      kept.engine = std::make_shared<const PastEngine>(statistics_.engine->iterations());
  } else {
    kept.position.stage = Stage::engine;
    kept.engine = engine_->save();
    kept.cellCount = cells_;
    const std::vector<Body> cells = engine_->cells();
    kept.cells.assign(cells.begin(), cells.end());
  }
  const auto& due = problem_.checkpoints->due;
  if (due && problem_.execution.communicator.any(due())) problem_.checkpoints->save(this->checkpointState());
}

const PackingState& Attempt::checkpointState() {
  kept_->cells = shares_.collect(std::move(kept_->cells));
  return *kept_;
}

/// If the run was continued from the end of another one, takes over the measures of the cells, provided they
/// are the same.
bool Attempt::keepMeasures() {
  if (!problem_.resume) return false;
  const PackingState& from = *problem_.resume;
  bool same = from.cells.size() == kept_->cells.size() && from.measures.size() == from.cells.size();
  for (std::size_t i = 0; same && i < from.cells.size(); ++i) {
    const MeasuresOfCell of = measuresOfCell(from.measures, i);
    same = isUnmoved(from.cells[i], kept_->cells[i]) &&
           std::all_of(of.begin(), of.end(), [](double number) { return std::isfinite(number); });
  }
  if (problem_.execution.communicator.any(!same)) return false;
  kept_->measures = from.measures;
  return true;
}

/// Measures the cells of the stored state.
void Attempt::measure() {
  placed_->relaxation.dropLists();
  CertificateInput input = inputNow();
  input.stop = {};
  endRelaxation();
  const CellMeasures measured = measureCells(problem_.physics, problem_.execution, input);
  std::vector<std::int64_t> own;
  for (std::size_t i = 0; i < input.own->size(); ++i)
    if ((*input.own)[i]) own.push_back(written_.ids()[i]);
  kept_->measures = shares_.collect(own, measured);
  written_ = WrittenCells(problem_);
}

/// Whether all contacts could be resolved within the limits.
bool Attempt::relaxed(std::int64_t maxSweeps) {
  Timer watch(statistics_.relaxationSeconds);
  ScheduleLimits all = limits(maxSweeps);
  all.sweepsForFew = problem_.execution.limits.sweepsForFew;
  std::optional<Relocated> relocated;
  all.unresolved = [&] { return (relocated = relocation()).has_value(); };
  while (!relax(placed_->relaxation, all, placed_->at.schedule)) {
    if (!relocated) return false;
    place(*std::exchange(relocated, {}), placed_->at);
  }
  placed_->at.stage = Stage::certificate;
  return true;
}

ScheduleLimits Attempt::limits(std::int64_t maxSweeps) {
  ScheduleLimits limits;
  limits.maxSweeps = maxSweeps;
  limits.stop = [this] { return control_.stopped(); };
  limits.beforeRebuild = [this] { keepState(); };
  if (problem_.execution.progress)
    limits.tell = [this](const char* stage) {
      problem_.execution.progress({stage, placed_->relaxation.sweeps(), 1.0,
                                   placed_->relaxation.lastSweep().deepest,
                                   placed_->relaxation.lastSweep().contacts});
    };
  return limits;
}

/// Certifies the cells of the relaxation; pairs and cells that fail get more clearance and are relaxed again.
/// Post: if false, the position is at relaxation, or the run is interrupted.
bool Attempt::certified() {
  RunPosition& at = placed_->at;
  const std::int64_t part = at.schedule.part;
  const RepairPolicy& policy = RepairPolicy::after(part);
  std::optional<Certifier> certifier;
  written_ = WrittenCells(problem_);
  for (; at.round < policy.rounds; ++at.round) {
    if (at.stage == Stage::certificate) {
      placed_->relaxation.dropLists();
      keepState();
      if (certifiedOnce(policy, certifier)) return true;
      if (control_.outOfTime()) return false;
      ++statistics_.repairs;
      at.stage = Stage::repair;
      at.schedule = {policy.calibrates ? part : 0, 0};
    }
    if (!settled(policy)) {
      const auto relocated = policy.calibrates ? std::nullopt : relocation();
      if (!relocated) break;
      place(*relocated, {Stage::relaxation, at.fewer, 0, {}});
      return false;
    }
    at.stage = Stage::certificate;
  }
  at = {Stage::relaxation, at.fewer, 0, {policy.calibrates ? part + 1 : 0, 0}};
  return false;
}

/// The certificate of the current cells of the relaxation.
Certificate Attempt::examined(const RepairPolicy& policy, std::optional<Certifier>& certifier) {
  const Timer watch(statistics_.certificateSeconds);
  const auto changed = certifier ? written_.update(placed_->relaxation) : std::nullopt;
  if (changed) {
    certifier->update(*changed);
  } else {
    CertificateInput input = inputNow();
    input.requiredGap += policy.range;
    certifier.emplace(input);
  }
  return ofAllRanks(certifier->certificate(), written_.ids(), problem_.execution.communicator);
}

/// @return whether the certificate is clean; if not, additional clearances have been demanded
bool Attempt::certifiedOnce(const RepairPolicy& policy, std::optional<Certifier>& certifier) {
  const Certificate found = examined(policy, certifier);
  if (repairs_.isMet(policy, found)) {
    certifier.reset();
    if (policy.range > 0.0) return cleanByChance();  // `found` has pairs that are far enough apart
    written_ = WrittenCells(problem_);
    deliver(found);
    return true;
  }
  if (found.complete) repairs_.demand(policy, found, placed_->relaxation);
  return false;
}

/// Relaxes what a certificate has demanded. @return whether it is worth another certificate
bool Attempt::settled(const RepairPolicy& policy) {
  Timer watch(statistics_.relaxationSeconds);
  const ScheduleLimits most =
      limits(placed_->relaxation.sweeps() + policy.sweeps - placed_->at.schedule.sweep);
  const bool resolved =
      relaxDeepContacts(placed_->relaxation, policy.sweeps, most, placed_->at.schedule, policy.calibrates);
  return policy.calibrates ? !control_.stopped() && !isTooDeepToCalibrate(placed_->relaxation) : resolved;
}

/// The cells with those that are stuck where there is more room; empty if there is none, or too many are
/// stuck.
std::optional<Attempt::Relocated> Attempt::relocation() {
  const std::int64_t most = std::clamp(placed_->relaxation.movableCount() / oneStuckOf, fewStuck, mostStuck);
  if (placed_->relaxation.lastSweep().contacts > contactsOfStuck * most ||
      placed_->relaxation.sweeps() > sweepsWithRelocation || control_.outOfTime())
    return {};
  placed_->relaxation.dropLists();
  const Certificate found = ofAllRanks(certify(inputNow()), written_.ids(), problem_.execution.communicator);
  written_ = WrittenCells(problem_);
  std::set<std::int64_t> stuck = failingCells(found, problem_.physics);
  stuck.erase(stuck.lower_bound(cells_), stuck.end());  // of an engine's reserve
  if (!found.complete || stuck.empty() || std::int64_t(stuck.size()) > most ||
      !found.selfIntersecting.empty())
    return {};
  Relocated after{placed_->relaxation.unsortedStates(), placed_->relaxation.state()};
  const std::set<std::int64_t> moved = relocate(problem_.physics, problem_.execution, control_.spaces(),
                                                placed_->relaxation.sweeps(), stuck, after.cells);
  if (moved.empty()) return {};
  auto& extra = after.state.extraClearance;
  for (auto pair = extra.begin(); pair != extra.end();)
    pair = moved.count(pair->first.first) || moved.count(pair->first.second) ? extra.erase(pair)
                                                                             : std::next(pair);
  repairs_.forget(moved);
  return after;
}

void Attempt::place(const Relocated& relocated, const RunPosition& at) {
  place(bodiesOf(relocated.cells), at, relocated.state);
}

/// Whether all cells are certified if a few may be closer to others and to the wall than required; they are
/// delivered then.
bool Attempt::certifiedWithSomeCloser() {
  const Physics& physics = problem_.physics;
  const std::int64_t most = placed_->relaxation.movableCount() / oneCloserOf;
  const bool ofTheirOwn =
      std::any_of(physics.species.begin(), physics.species.end(),
                  [](const Species& species) { return species.freedom.extraWallClearance > 0.0; });
  if (!problem_.execution.limits.someCloser || most == 0 || ofTheirOwn) return false;
  std::set<std::int64_t> closer, closerToWall;
  std::set<std::pair<std::int64_t, std::int64_t>> pairs;
  for (std::int64_t round = 0; round < closerRounds && !control_.outOfTime(); ++round) {
    placed_->relaxation.dropLists();
    Certificate found = ofAllRanks(certify(inputNow()), written_.ids(), problem_.execution.communicator);
    if (!found.complete || found.moreOverlaps) break;
    const Certificate tooNear = onlyTooNear(found);
    closer = failingCells(tooNear, physics, std::move(closer));
    const std::size_t meeting = found.overlapping.size() - tooNear.overlapping.size() +
                                found.misplaced.size() - tooNear.misplaced.size();
    if (std::int64_t(closer.size()) > most || std::int64_t(meeting) > most + fewStuck) break;
    Certificate rest = found;
    rest.closer = permit(closer, rest);
    if (rest.clean()) {
      deliver(rest);
      written_ = WrittenCells(problem_);
      return true;
    }
    // Those that meet others or the wall are repaired; the permitted ones get less clearance, once.
    for (const OverlappingPair& pair : found.overlapping)
      if (!(pair.gap > 0.0))
        placed_->relaxation.demandClearance(pair.first, pair.second, tolerance::repairClearance);
      else if (pairs.insert({pair.first, pair.second}).second)
        placed_->relaxation.demandClearance(pair.first, pair.second, -physics.clearance);
    for (const MisplacedCell& cell : found.misplaced)
      if (!(cell.gap > 0.0))
        placed_->relaxation.demandWallClearance(cell.cell, tolerance::repairClearance);
      else if (closerToWall.insert(cell.cell).second)
        placed_->relaxation.demandWallClearance(cell.cell, -physics.wallClearance);
    SchedulePosition start;
    ScheduleLimits some = limits(placed_->relaxation.sweeps() + closerSweeps);
    some.beforeRebuild = {};  // a restart begins these rounds again
    relaxDeepContacts(placed_->relaxation, closerSweeps, some, start);
  }
  written_ = WrittenCells(problem_);
  return false;
}

/// Assigns every rank its share of the certified cells, sorted by id. @param whole none was left out
void Attempt::deliver(const Certificate& certificate, bool whole) {
  const std::vector<BodyState> states = shares_.collect(placed_->relaxation.unsortedStates());
  PackingResult& result = end_.emplace<PackingResult>();
  result.poses.resize(states.size());
  result.cells.resize(states.size());
  problem_.execution.threads.forEachPart(
      static_cast<std::int64_t>(states.size()), [&](std::int64_t begin, std::int64_t end, int) {
        for (std::int64_t i = begin; i < end; ++i) {
          const Pose pose = result.poses[i] = states[i].pose();
          result.cells[i] = {states[i].species, states[i].shape, problem_.physics.placement(pose)};
        }
      });
  result.counts.assign(problem_.physics.species.size(), 0);
  for (const BodyState& state : states) ++result.counts[state.species];
  result.cellCount = placed_->relaxation.cellCount();
  result.certificate = certificate;
  result.outcome = whole && result.cellCount >= cells_ ? Outcome::certified : Outcome::outOfReach;
}

bool Attempt::leaveOutFailing() {
  if (!placed_ && engine_ && engine_->hasBegun()) takeFromEngine();
  if (!placed_) return false;
  Timer watch(statistics_.certificateSeconds);
  placed_->relaxation.dropLists();
  while (!control_.outOfTime()) {
    const Certificate found =
        ofAllRanks(certify(inputNow()), written_.ids(), problem_.execution.communicator);
    if (!found.complete) break;
    if (found.clean()) {
      deliver(found, false);
      return true;
    }
    const std::set<std::int64_t> out = failingCells(found, problem_.physics);
    placed_->relaxation.remove({out.begin(), out.end()});
  }
  return false;
}

void Attempt::take(const PackingResult& other) {
  // Ids of the cells in the complete problem: the first ones of every species.
  const std::vector<std::int64_t> before = problem_.execution.communicator.sumBefore(other.counts);
  std::vector<Body> bodies;
  std::int64_t first = 0;  // id
  for (std::size_t s = 0; s < other.counts.size(); ++s) {
    for (std::int64_t n = 0; n < other.counts[s]; ++n)
      bodies.push_back(makeBody(first + before[s] + n, static_cast<int>(s), other.cells[bodies.size()].shape,
                                other.poses[bodies.size()]));
    first += problem_.physics.species[s].count;
  }
  const bool whole = other.cellCount >= cells_;
  RelaxationState state;
  state.sweeps = placed_ ? placed_->relaxation.sweeps() : 0;
  place(std::move(bodies), {Stage::certificate, !whole, 0, {}}, state);
  repairs_.clear();
  PackingResult& result = end_.emplace<PackingResult>(other);
  result.outcome = whole ? Outcome::certified : Outcome::outOfReach;
}

void Attempt::keepEnd() {
  if (!problem_.checkpoints || !placed_) return;
  keepState();
  checkpointState();
  if (!keepMeasures()) measure();
}

}  // namespace packmesh
