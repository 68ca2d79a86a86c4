// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/attempt.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "packMesh/analysis/cell_measures.h"
#include "packMesh/certificate/certify.h"
#include "packMesh/core/timer.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/packing/calibration.h"
#include "packMesh/packing/placed_cells.h"
#include "packMesh/relaxation/schedule.h"

namespace packmesh {
namespace {

/// Number of repair rounds after which a packing counts as unresolved, and sweeps in each.
constexpr int repairRounds = 60;
constexpr std::int64_t repairSweeps = 400;

/// The same of calibration.
constexpr int calibrationRounds = 30;
constexpr std::int64_t calibrationSweeps = 300;

/// Thin parts of cells can pierce each other between their sample points, where a small increase of the
/// clearance has no effect: for pairs that fail more often than this, the increase doubles every time.
constexpr int patience = 2;

bool isUnmoved(const BodyState& before, const BodyState& after) {
  const auto& a = before.pose;
  const auto& b = after.pose;
  return before.id == after.id && before.species == after.species && before.scale == after.scale &&
         std::equal(std::begin(a.position), std::end(a.position), b.position) &&
         std::equal(std::begin(a.orientation), std::end(a.orientation), b.orientation);
}

}  // namespace

PackingResult attempt(const PackingProblem& problem) {
  RunControl control(problem);
  Attempt once(problem, control);
  once.certifyAll();
  return once.takeResult();
}

Attempt::Attempt(const PackingProblem& problem, RunControl& control)
    : problem_(problem),
      control_(control),
      cells_(problem.physics.cellCount()),
      shares_(cells_, problem.execution.communicator),
      written_(problem) {}

bool Attempt::certifyAll(std::int64_t sweeps) {
  if (over_) return false;
  const std::int64_t most = std::min(sweeps, problem_.execution.limits.maxSweeps);
  if (!relaxation_) {
    begin();
    if (growth_ && !grown(most)) return false;
    if (!relaxation_ || control_.interrupted()) return false;
    keepState();
    if (startsClean()) return true;
    if (at_.fewer) return certified();
  }
  while (relaxed(most))
    if (certified()) return true;
  const bool suspended = most < problem_.execution.limits.maxSweeps && relaxation_->sweeps() >= most;
  if (suspended || control_.interrupted()) return false;
  over_ = true;
  return cleanByChance();
}

PackingResult Attempt::takeResult() {
  const bool all = delivered_ && result_.cellCount >= cells_ && !leftOut_;
  result_.outcome = control_.interrupted() ? Outcome::interrupted
                    : all                  ? Outcome::certified
                                           : Outcome::outOfReach;
  if (!delivered_ || control_.interrupted()) {
    result_.cells.clear();
    result_.poses.clear();
    result_.cellCount = 0;
    result_.certificate = {};
  }
  if (relaxation_) {
    result_.statistics.blocks = relaxation_->blockCount();
    result_.statistics.sweeps = relaxation_->sweeps();
  }
  return std::move(result_);
}

/// Places the cells, or takes them from the state to resume.
void Attempt::begin() {
  if (growth_) return;
  const bool grows = problem_.method.kind == Method::cat;
  if (problem_.resume && !(grows && problem_.resume->position.stage == Stage::growth)) {
    if (grows) result_.statistics.growth.emplace().iterations = problem_.resume->growth.iterations;
    resume(*problem_.resume);
  } else if (grows) {
    growth_.emplace(problem_, control_, result_.statistics, [this] { keepState(); });
    if (growth_->hasBegun()) keepState();
  } else {
    const Timer watch(result_.statistics.placementSeconds);
    if (std::optional<std::vector<Body>> bodies =
            placedCells(problem_.physics, problem_.execution, shares_, control_))
      relaxFrom(std::move(*bodies));
  }
}

void Attempt::resume(const PackingState& state) {
  at_ = state.position;
  if (at_.fewer) at_ = {Stage::certificate, true, 0, {}};
  result_.statistics.repairs = state.repairs;
  failures_ = state.failures;
  demandedOfWall_ = state.demandedOfWall;
  shares_ = IdShares(std::max(cells_, state.cellCount), problem_.execution.communicator);
  relaxFrom(bodiesOf(state.cells), state.relaxation);
}

void Attempt::relaxFrom(std::vector<Body> bodies, const RelaxationState& state) {
  relaxation_.emplace(problem_.physics, problem_.execution, std::move(bodies), state);
}

/// Whether all cells have grown to full size; if so, they are ready for the certificate.
bool Attempt::grown(std::int64_t iterations) {
  if (!growth_->run(iterations)) {
    over_ =
        !control_.interrupted() && (growth_->ended() || iterations >= problem_.execution.limits.maxSweeps);
    return false;
  }
  takeGrown();
  return true;
}

/// Replaces the growth stage by a relaxation of its cells of full size.
void Attempt::takeGrown() {
  std::vector<Body> cells = growth_->fullCells();
  std::int64_t last = 0;  // an escape may have added cells
  for (const Body& cell : cells) last = std::max(last, cell.id + 1);
  last = -problem_.execution.communicator.min(-last);
  shares_ = IdShares(std::max(cells_, last), problem_.execution.communicator);
  result_.statistics.tetrahedra = growth_->tetrahedra();
  relaxFrom(std::move(cells));
  at_ = {Stage::certificate, false, 0, {}};
}

/// If initial poses are given for all cells and they form a valid packing, it is kept unchanged.
bool Attempt::startsClean() {
  const bool whole =
      std::all_of(problem_.physics.species.begin(), problem_.physics.species.end(),
                  [](const Species& s) { return static_cast<std::int64_t>(s.start.size()) >= s.count; });
  if (!whole || growth_ || relaxation_->sweeps() > 0 || relaxation_->cellCount() == 0) return false;
  return cleanByChance();
}

/// Whether the current cells pass the certificate; if so, they are delivered. Stops at the first violation.
bool Attempt::cleanByChance() {
  const Timer watch(result_.statistics.certificateSeconds);
  relaxation_->dropLists();
  written_.take(*relaxation_);
  CertificateInput input = written_.certificateInput();
  input.stop = [this] { return control_.outOfTimeHere(); };
  input.upToFirstFault = true;
  const Certificate found = ofAllRanks(certify(input), written_.ids(), problem_.execution.communicator);
  written_ = WrittenCells(problem_);
  if (!found.clean()) return false;
  result_.certificate = found;
  deliver();
  return true;
}

/// Stores the state that is saved if the run ends before the next call. Pre: there are cells; the relaxation
/// is about to rebuild its lists.
void Attempt::keepState() {
  if (!problem_.checkpoints) return;
  kept_ = PackingState();
  if (relaxation_) {
    kept_.position = at_;
    kept_.repairs = result_.statistics.repairs;
    kept_.relaxation = relaxation_->state();
    kept_.failures = failures_;
    kept_.demandedOfWall = demandedOfWall_;
    kept_.cellCount = relaxation_->cellCount();
    kept_.cells = shares_.collect(relaxation_->cells());
    if (result_.statistics.growth) kept_.growth.iterations = result_.statistics.growth->iterations;
  } else {
    kept_.position.stage = Stage::growth;
    kept_.growth = growth_->position();
    kept_.cellCount = cells_;
    kept_.cells = shares_.collect(growth_->cells());
  }
  const auto& due = problem_.checkpoints->due;
  if (due && problem_.execution.communicator.any(due())) problem_.checkpoints->save(kept_);
}

/// If the run was continued from the end of another one, takes over the measures of the cells, provided they
/// are the same.
bool Attempt::keepMeasures() {
  if (!problem_.resume) return false;
  const PackingState& from = *problem_.resume;
  bool same = from.cells.size() == kept_.cells.size() && from.measures.gap.size() == from.cells.size() &&
              from.measures.localHematocrit.size() == from.cells.size();
  for (std::size_t i = 0; same && i < from.cells.size(); ++i)
    same = isUnmoved(from.cells[i], kept_.cells[i]) && std::isfinite(from.measures.gap[i]) &&
           std::isfinite(from.measures.localHematocrit[i]);
  if (problem_.execution.communicator.any(!same)) return false;
  kept_.measures = from.measures;
  return true;
}

/// Measures the cells of the stored state.
void Attempt::measure() {
  relaxation_->dropLists();
  written_.take(*relaxation_);
  const CertificateInput input = written_.certificateInput();
  const CellMeasures measured = measureCells(problem_.physics, problem_.execution, input);
  struct Measure {
    std::int64_t id;
    double gap, localHematocrit;
  };
  std::vector<Measure> own;
  for (std::size_t i = 0; i < input.own->size(); ++i)
    if ((*input.own)[i])
      own.push_back({written_.ids()[i], measured.gap[own.size()], measured.localHematocrit[own.size()]});
  kept_.measures = {};
  for (const Measure& m : shares_.collect(own)) {
    kept_.measures.gap.push_back(m.gap);
    kept_.measures.localHematocrit.push_back(m.localHematocrit);
  }
  written_ = WrittenCells(problem_);
}

/// Whether all contacts could be resolved within the limits.
bool Attempt::relaxed(std::int64_t maxSweeps) {
  if (control_.outOfTime()) return false;
  if (at_.stage != Stage::relaxation) return true;  // already done
  Timer watch(result_.statistics.relaxationSeconds);
  ScheduleLimits all = limits(maxSweeps);
  all.sweepsForFew = problem_.execution.limits.sweepsForFew;
  if (!relax(*relaxation_, tolerance::relaxationTolerance, all, at_.schedule)) return false;
  at_.stage = Stage::certificate;
  return true;
}

ScheduleLimits Attempt::limits(std::int64_t maxSweeps) {
  ScheduleLimits limits;
  limits.maxSweeps = maxSweeps;
  limits.stop = [this] { return control_.stopped(); };
  limits.anew = [this] { keepState(); };
  if (problem_.execution.progress)
    limits.tell = [this](const char* stage) {
      problem_.execution.progress({stage, relaxation_->sweeps(), 1.0, relaxation_->lastSweep().deepest,
                                   relaxation_->lastSweep().contacts});
    };
  return limits;
}

/// Certifies the cells of the relaxation; pairs and cells that fail get more clearance and are relaxed again.
/// Post: if false, the position is at relaxation, or the run is interrupted.
bool Attempt::certified() {
  if (isCompaction(at_.schedule.part)) return calibrated();
  std::optional<Certifier> certifier;
  written_ = WrittenCells(problem_);
  for (; at_.round < repairRounds; ++at_.round) {
    if (at_.stage == Stage::certificate) {
      relaxation_->dropLists();
      keepState();
      if (certifiedOnce(certifier)) return true;
      if (control_.outOfTime()) return false;
      ++result_.statistics.repairs;
      at_.stage = Stage::repair;
      at_.schedule = {};
    }
    if (!settled(repairSweeps)) break;
    at_.stage = Stage::certificate;
  }
  at_ = {Stage::relaxation, at_.fewer, 0, {}};
  return false;
}

/// The certificate of the current cells of the relaxation.
Certificate Attempt::examined(std::optional<Certifier>& certifier) {
  const auto changed = certifier ? written_.update(*relaxation_) : std::nullopt;
  if (changed) {
    certifier->update(*changed);
  } else {
    written_.take(*relaxation_);
    CertificateInput input = written_.certificateInput();
    input.stop = [this] { return control_.outOfTimeHere(); };
    certifier.emplace(input);
  }
  return ofAllRanks(certifier->certificate(), written_.ids(), problem_.execution.communicator);
}

/// @return whether the certificate is clean; if not, additional clearances have been demanded
bool Attempt::certifiedOnce(std::optional<Certifier>& certifier) {
  Timer watch(result_.statistics.certificateSeconds);
  const Certificate found = examined(certifier);
  if (found.clean()) {
    result_.certificate = found;
    certifier.reset();
    written_ = WrittenCells(problem_);
    deliver();
    return true;
  }
  if (!found.complete) return false;
  for (const OverlappingPair& pair : found.overlapping) {
    const std::int64_t again = std::max<std::int64_t>(0, ++failures_[{pair.first, pair.second}] - patience);
    relaxation_->demandClearance(pair.first, pair.second,
                                 std::ldexp(tolerance::repairClearance, static_cast<int>(again)));
  }
  for (const MisplacedCell& cell : found.misplaced) demandDistance(cell);
  return false;
}

/// As certified(), after a compaction. Post: if false, the position is at the next one, or the run is
/// interrupted.
bool Attempt::calibrated() {
  const std::int64_t part = at_.schedule.part;
  for (; at_.round < calibrationRounds; ++at_.round) {
    if (at_.stage == Stage::certificate) {
      relaxation_->dropLists();
      keepState();
      if (calibratedOnce()) return true;
      if (control_.outOfTime()) return false;
      ++result_.statistics.repairs;
      at_.stage = Stage::repair;
      at_.schedule.sweep = 0;
    }
    const Timer watch(result_.statistics.relaxationSeconds);
    const std::int64_t most = relaxation_->sweeps() + calibrationSweeps - at_.schedule.sweep;
    settleCompacted(*relaxation_, tolerance::relaxationTolerance, calibrationSweeps, limits(most),
                    at_.schedule);
    if (control_.stopped() || isTooDeepToCalibrate(*relaxation_)) break;
    at_.stage = Stage::certificate;
  }
  at_ = {Stage::relaxation, at_.fewer, 0, {part + 1, 0}};
  return false;
}

/// @return whether the certificate is clean; if not, the clearances have been corrected
bool Attempt::calibratedOnce() {
  Timer watch(result_.statistics.certificateSeconds);
  written_.take(*relaxation_);
  CertificateInput input = written_.certificateInput();
  input.requiredGap += Calibration::range;  // all nearer pairs are listed, with their gaps
  input.stop = [this] { return control_.outOfTimeHere(); };
  const Certificate found = ofAllRanks(certify(input), written_.ids(), problem_.execution.communicator);
  if (!found.complete) return false;
  const double required = problem_.physics.clearance;
  const bool clean = found.misplaced.empty() &&
                     std::none_of(found.overlapping.begin(), found.overlapping.end(),
                                  [&](const OverlappingPair& p) { return p.gap <= 0.0 || p.gap < required; });
  if (clean) return cleanByChance();
  const ExtraClearances extra = relaxation_->state().extraClearance;
  for (const OverlappingPair& pair : found.overlapping) {
    const auto known = extra.find(std::minmax(pair.first, pair.second));
    const double correction =
        Calibration::correction(pair.gap, required, known == extra.end() ? 0.0 : known->second);
    if (correction != 0.0) relaxation_->demandClearance(pair.first, pair.second, correction);
  }
  for (const MisplacedCell& cell : found.misplaced) demandDistance(cell);
  return false;
}

/// Continues with settle().
bool Attempt::settled(std::int64_t sweeps) {
  Timer watch(result_.statistics.relaxationSeconds);
  const std::int64_t most = relaxation_->sweeps() + sweeps - at_.schedule.sweep;
  return settle(*relaxation_, tolerance::relaxationTolerance, sweeps, limits(most), at_.schedule);
}

/// Assigns every rank its share of the cells, sorted by id.
void Attempt::deliver() {
  const std::vector<BodyState> states = shares_.collect(relaxation_->cells());
  result_.poses.resize(states.size());
  result_.cells.resize(states.size());
  problem_.execution.threads.forEachPart(
      static_cast<std::int64_t>(states.size()), [&](std::int64_t begin, std::int64_t end, int) {
        for (std::int64_t i = begin; i < end; ++i) {
          const Pose pose = result_.poses[i] = bodyOf(states[i]).pose();
          result_.cells[i] = {states[i].species, problem_.physics.placement(pose)};
        }
      });
  result_.cellCount = relaxation_->cellCount();
  delivered_ = true;
}

/// Additional clearance of a misplaced cell: what relaxation missed because it interpolates the distance to
/// the wall.
void Attempt::demandDistance(const MisplacedCell& cell) {
  constexpr double growth = 0.5;  // its depth in the wall is unknown: demand more each time
  double& demanded = demandedOfWall_[cell.cell];
  const double wanted = cell.gap > 0.0
                            ? problem_.physics.wallClearance - cell.gap + tolerance::repairClearance
                            : std::max(tolerance::repairClearance, growth * demanded);
  const double most = problem_.physics.container->bounds().size().norm();
  const double extra = std::clamp(wanted, 0.0, std::max(0.0, most - demanded));
  demanded += extra;
  relaxation_->demandWallClearance(cell.cell, extra);
}

bool Attempt::leaveOutFailing() {
  if (!relaxation_ && growth_ && growth_->hasBegun()) takeGrown();
  if (!relaxation_) return false;
  leftOut_ = true;
  Timer watch(result_.statistics.certificateSeconds);
  while (!control_.outOfTime()) {
    relaxation_->dropLists();
    written_.take(*relaxation_);
    CertificateInput input = written_.certificateInput();
    input.stop = [this] { return control_.outOfTimeHere(); };
    const Certificate found = ofAllRanks(certify(input), written_.ids(), problem_.execution.communicator);
    if (!found.complete) break;
    if (found.clean()) {
      result_.certificate = found;
      deliver();
      return true;
    }
    std::map<std::int64_t, int> failures;
    std::set<std::int64_t> out;
    for (const MisplacedCell& cell : found.misplaced) out.insert(cell.cell);
    for (const OverlappingPair& pair : found.overlapping) ++failures[pair.first], ++failures[pair.second];
    for (const OverlappingPair& pair : found.overlapping) {
      if (out.count(pair.first) || out.count(pair.second)) continue;
      const bool first =
          isFixed(pair.second) || (!isFixed(pair.first) && failures[pair.first] > failures[pair.second]);
      out.insert(first ? pair.first : pair.second);
    }
    relaxation_->remove({out.begin(), out.end()});
  }
  return false;
}

bool Attempt::isFixed(std::int64_t id) const {
  for (const Species& species : problem_.physics.species) {
    if (id < species.count) return species.freedom.fixed;
    id -= species.count;
  }
  return false;
}

void Attempt::take(const PackingResult& fewer) {
  // Ids of the cells in the complete problem: the first ones of every species.
  std::vector<std::int64_t> counts(problem_.physics.species.size(), 0);
  for (const PlacedCell& cell : fewer.cells) ++counts[cell.species];
  std::vector<std::int64_t> before = problem_.execution.communicator.sumBefore(counts);
  std::vector<Body> bodies;
  for (std::size_t i = 0; i < fewer.cells.size(); ++i) {
    const int of = fewer.cells[i].species;
    std::int64_t id = before[of]++;
    for (int s = 0; s < of; ++s) id += problem_.physics.species[s].count;
    bodies.push_back(makeBody(id, of, fewer.poses[i]));
  }
  RelaxationState state;
  state.sweeps = relaxation_ ? relaxation_->sweeps() : 0;
  relaxFrom(std::move(bodies), state);
  at_ = {Stage::certificate, true, 0, {}};
  failures_.clear();
  demandedOfWall_.clear();
  result_.cells = fewer.cells;
  result_.poses = fewer.poses;
  result_.cellCount = fewer.cellCount;
  result_.certificate = fewer.certificate;
  delivered_ = true;
}

void Attempt::keepEnd() {
  if (!problem_.checkpoints || !relaxation_) return;
  keepState();
  if (!keepMeasures()) measure();
}

}  // namespace packmesh
