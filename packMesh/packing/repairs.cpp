// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/repairs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "packMesh/core/tolerances.h"
#include "packMesh/parallel/blocks.h"
#include "packMesh/relaxation/schedule.h"

namespace packmesh {

namespace {

/// Cells that moved are sent to every rank as long as they are few.
constexpr double fewMoved = 0.02;
constexpr std::int64_t alwaysFew = 1000;

}  // namespace

void WrittenCells::take(Relaxation& relaxation) {
  *this = WrittenCells(*problem_);
  const std::vector<BodyState> states = relaxation.statesAround();
  ids_.reserve(states.size());
  own_.reserve(states.size());
  for (const BodyState& state : states) {
    ids_.push_back(state.id);
    own_.push_back(relaxation.owns(state));
  }
  cells_.resize(states.size());
  problem_->execution.threads.forEachPart(
      static_cast<std::int64_t>(states.size()), [&](std::int64_t begin, std::int64_t end, int) {
        for (std::int64_t i = begin; i < end; ++i)
          cells_[i] = {states[i].species, states[i].shape, problem_->physics.placement(states[i].pose())};
      });
  relaxation.forgetTouched();
}

std::optional<std::vector<std::int64_t>> WrittenCells::update(Relaxation& relaxation) {
  const Communicator& ranks = problem_->execution.communicator;
  const std::vector<BodyState> moved = relaxation.touchedStates();
  const double few =
      std::max(static_cast<double>(alwaysFew), fewMoved * static_cast<double>(relaxation.cellCount()));
  if (static_cast<double>(ranks.sum(static_cast<std::int64_t>(moved.size()))) > few && !ranks.alone())
    return {};
  relaxation.forgetTouched();
  const Vec3 period = problem_->physics.container->period();
  std::vector<std::int64_t> changed;
  bool far = false;
  for (const BodyState& state : ranks.gatherAll(moved)) {
    const auto at = std::lower_bound(ids_.begin(), ids_.end(), state.id);
    if (at == ids_.end() || *at != state.id) continue;
    const std::int64_t i = at - ids_.begin();
    Placement& known = cells_[i].placement;
    const Placement now = problem_->physics.placement(state.pose());
    if (known.linear == now.linear && known.translation == now.translation) continue;
    const Vec3& from = takenAt_.emplace(i, known.translation).first->second;
    far = far || nearestImage(now.translation - from, period).norm() > Relaxation::certifiedMotion;
    known = now;
    changed.push_back(i);
  }
  if (!ranks.alone() && ranks.any(far)) return {};
  std::sort(changed.begin(), changed.end());
  return changed;
}

CertificateInput WrittenCells::certificateInput() const {
  CertificateInput input = certificateInputOf(problem_->physics, cells_, problem_->execution.threads);
  input.own = &own_;
  return input;
}

namespace {

/// Pairs whose gap exceeds the required one by more than this keep their clearance in a calibration [µm].
constexpr double calibrationRange = 0.03;

constexpr RepairPolicy repair{60, 400, 0.0, false}, calibration{30, 300, calibrationRange, true};

/// Thin parts of cells can pierce each other between their sample points, where a small increase of the
/// clearance has no effect: for pairs that fail more often than this, the increase doubles every time.
constexpr int patience = 2;

/// Excess of the gap that calibration aims at, and below which it is increased [µm]: cells move by
/// thousandths of a micrometre in each round.
constexpr double wantedExcess = 0.0015, leastExcess = 0.001;

/// Fraction of the difference that is corrected in a round, and largest reduction in a round [µm]: when all
/// pairs get nearer at the same time, their gaps change by more than their clearances.
constexpr double fraction = 0.8, largestReduction = 0.006;

/// No pair is allowed to be nearer than this by its sample points [µm].
constexpr double nearest = -0.01;

/// Resolution of corrections.
constexpr double stepsPerMicrometre = 0x1p14;

bool isFixed(std::int64_t id, const Physics& physics) {
  for (const Species& species : physics.species) {
    if (id < species.count) return species.freedom.fixed;
    id -= species.count;
  }
  return false;
}

}  // namespace

const RepairPolicy& RepairPolicy::after(std::int64_t part) {
  return isCompaction(part) ? calibration : repair;
}

bool Repairs::isMet(const RepairPolicy& policy, const Certificate& found) const {
  if (!policy.calibrates) return found.clean();
  return found.complete && found.misplaced.empty() && found.selfIntersecting.empty() &&
         std::none_of(found.overlapping.begin(), found.overlapping.end(),
                      [&](const OverlappingPair& p) { return p.gap <= 0.0 || p.gap < physics_.clearance; });
}

void Repairs::demand(const RepairPolicy& policy, const Certificate& found, Relaxation& relaxation) {
  if (policy.calibrates)
    calibratePairs(found, relaxation);
  else
    demandOfPairs(found, relaxation);
  for (const MisplacedCell& cell : found.misplaced) demandOfWall(cell, relaxation);
}

void Repairs::demandOfPairs(const Certificate& found, Relaxation& relaxation) {
  for (const OverlappingPair& pair : found.overlapping) {
    const std::int64_t again = std::max<std::int64_t>(0, ++failures_[{pair.first, pair.second}] - patience);
    relaxation.demandClearance(pair.first, pair.second,
                               std::ldexp(tolerance::repairClearance, static_cast<int>(again)));
  }
}

void Repairs::calibratePairs(const Certificate& found, Relaxation& relaxation) const {
  const ExtraClearances extra = relaxation.state().extraClearance;
  for (const OverlappingPair& pair : found.overlapping) {
    const auto known = extra.find(std::minmax(pair.first, pair.second));
    const double correction =
        clearanceCorrection(pair.gap, physics_.clearance, known == extra.end() ? 0.0 : known->second);
    if (correction != 0.0) relaxation.demandClearance(pair.first, pair.second, correction);
  }
}

/// Additional clearance of a misplaced cell: what relaxation missed because it interpolates the distance to
/// the wall.
void Repairs::demandOfWall(const MisplacedCell& cell, Relaxation& relaxation) {
  constexpr double more = 0.5;  // its depth in the wall is unknown: demand more each time
  double& demanded = demandedOfWall_[cell.cell];
  const double wanted = cell.gap > 0.0 ? cell.required - cell.gap + tolerance::repairClearance
                                       : std::max(tolerance::repairClearance, more * demanded);
  const double most = physics_.largest(&Shape::reach);  // more than relaxation can miss
  const double extra = std::clamp(wanted, 0.0, std::max(0.0, most - demanded));
  demanded += extra;
  relaxation.demandWallClearance(cell.cell, extra);
}

void Repairs::restore(const PackingState& state) {
  failures_ = state.failures;
  demandedOfWall_ = state.demandedOfWall;
}

void Repairs::store(PackingState& state) const {
  state.failures = failures_;
  state.demandedOfWall = demandedOfWall_;
}

void Repairs::clear() {
  failures_.clear();
  demandedOfWall_.clear();
}

void Repairs::forget(const std::set<std::int64_t>& ids) {
  for (auto pair = failures_.begin(); pair != failures_.end();)
    pair = ids.count(pair->first.first) || ids.count(pair->first.second) ? failures_.erase(pair)
                                                                         : std::next(pair);
  for (const std::int64_t id : ids) demandedOfWall_.erase(id);
}

double clearanceCorrection(double gap, double required, double extra) {
  if (gap <= 0.0) return tolerance::repairClearance;
  const double excess = gap - required;
  if (excess >= leastExcess && excess <= wantedExcess) return 0.0;
  const double least = nearest - tolerance::relaxationMargin + tolerance::compactionSlack;
  const double wanted = std::max(fraction * (wantedExcess - excess), -largestReduction);
  return std::floor(std::max(wanted, std::min(0.0, least - extra)) * stepsPerMicrometre) / stepsPerMicrometre;
}

std::set<std::int64_t> failingCells(const Certificate& found, const Physics& physics,
                                    std::set<std::int64_t> known) {
  std::map<std::int64_t, int> failures;
  std::set<std::int64_t> out = std::move(known);
  for (const MisplacedCell& cell : found.misplaced) out.insert(cell.cell);
  for (const SelfIntersectingCell& one : found.selfIntersecting) out.insert(one.cell);
  for (const OverlappingPair& pair : found.overlapping) ++failures[pair.first], ++failures[pair.second];
  for (const OverlappingPair& pair : found.overlapping) {
    if (out.count(pair.first) || out.count(pair.second)) continue;
    const bool first = isFixed(pair.second, physics) ||
                       (!isFixed(pair.first, physics) && failures[pair.first] > failures[pair.second]);
    out.insert(first ? pair.first : pair.second);
  }
  return out;
}

}  // namespace packmesh
