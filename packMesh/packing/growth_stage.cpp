// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/growth_stage.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "packMesh/cat/growth_relaxation.h"
#include "packMesh/core/timer.h"
#include "packMesh/packing/placed_cells.h"

namespace packmesh {
namespace {

/// Number of stalls until an attempt gives up, except in the last attempt.
constexpr int giveUpAfter = 2;

/// Seeds of successive attempts differ by this.
constexpr std::uint64_t attemptStride = 0x9E3779B97F4A7C15u;

}  // namespace

GrowthStage::GrowthStage(const PackingProblem& problem, RunControl& control, Statistics& statistics,
                         std::function<void()> keep)
    : problem_(problem),
      control_(control),
      statistics_(statistics),
      keep_(std::move(keep)),
      attempts_(std::max<std::int64_t>(
          1, problem.method.growth.attempts / std::max<std::int64_t>(1, problem.physics.cellCount()))),
      physics_(problem.physics),
      execution_(problem.execution),
      settings_(problem.method.growth) {
  execution_.interrupted = [this] { return control_.stoppedHere(); };
  statistics_.growth.emplace();
  planeFunction_ = makePlaneFunction(problem.method.planeSource, physics_, execution_, tetrahedra_);
  callbacks_.stop = [this] { return stopped(); };
  callbacks_.checkpoint = keep_;
  if (problem.execution.progress)
    callbacks_.progress = [this](double barrier, std::int64_t below, const GrowthStatistics& sums) {
      problem_.execution.progress({"growth", sums.iterations, barrier, 0.0, below});
    };
  if (problem.execution.observe)
    callbacks_.accepted = [this](const std::vector<Body>& now) { problem_.execution.observe(placed(now)); };
  if (problem.resume && problem.resume->position.stage == Stage::growth) resume(*problem.resume);
}

bool GrowthStage::stopped() {
  return control_.stopped() || iterations() >= problem_.execution.limits.maxSweeps;
}

bool GrowthStage::run(std::int64_t iterations) {
  while (!ended_) {
    if (!growth_) begin();
    if (!growth_) return false;  // no time was left for it
    const Timer watch(statistics_.growthSeconds);
    const bool full = growth_->run(iterations);
    if (!full && !growth_->ended()) return false;
    keepBest(growth_->cells());
    growth_.reset();
    ended_ = full || ++attempt_ == attempts_;
    if (ended_ && problem_.method.escape && (!full || anyReserve()) && !stopped()) escapeFromBest();
  }
  return complete(best_);
}

/// Places the initial cells of an attempt.
void GrowthStage::begin() {
  physics_.seed = problem_.physics.seed + static_cast<std::uint64_t>(attempt_) * attemptStride;
  const IdShares shares(problem_.physics.cellCount(), problem_.execution.communicator);
  std::vector<Body> cells;
  {
    const Timer watch(statistics_.placementSeconds);
    std::optional<std::vector<Body>> placed = placedCells(physics_, execution_, shares, control_);
    if (!placed) return;
    cells = std::move(*placed);
    std::vector<std::int64_t> first = {0};
    for (const Species& species : problem_.physics.species) first.push_back(first.back() + species.count);
    for (Body& cell : cells)
      if (!startsAtGivenPose(problem_.physics.species[cell.species], cell.id - first[cell.species]))
        cell.scale = settings_.initialScale;
    if (!seed(physics_, execution_, settings_.initialScale, callbacks_.stop, cells)) {
      ended_ = !stopped();
      return;
    }
  }
  growFrom(std::move(cells), {});
  keep_();
}

void GrowthStage::growFrom(std::vector<Body> cells, const GrowthProgress& from) {
  settings_.giveUpAfter = attempt_ + 1 < attempts_ ? giveUpAfter : problem_.method.growth.giveUpAfter;
  growth_ = std::make_unique<Growth>(physics_, execution_, settings_, *planeFunction_, callbacks_,
                                     std::move(cells), *statistics_.growth, from);
}

void GrowthStage::resume(const PackingState& state) {
  attempt_ = state.growth.attempt;
  statistics_.growth->iterations = state.growth.iterations;
  physics_.seed = problem_.physics.seed + static_cast<std::uint64_t>(attempt_) * attemptStride;
  keepBest(bodiesOf(state.growth.best));
  growFrom(bodiesOf(state.cells), state.growth.progress);
}

GrowthPosition GrowthStage::position() const {
  GrowthPosition position;
  position.attempt = attempt_;
  position.iterations = iterations();
  if (growth_) position.progress = growth_->progress();
  position.best = IdShares(problem_.physics.cellCount(), problem_.execution.communicator).collect(best_);
  return position;
}

std::vector<Body> GrowthStage::cells() const {
  return growth_ ? growth_->cells() : best_;
}

void GrowthStage::keepBest(std::vector<Body> cells) {
  const std::int64_t full = countFull(cells);
  if (full <= bestFull_) return;
  bestFull_ = full;
  best_ = std::move(cells);
}

std::vector<Body> GrowthStage::fullCells() const {
  std::vector<Body> now = cells(), full;
  if (countFull(now) <= bestFull_) now = best_;
  for (const Body& cell : now)
    if (cell.scale == 1.0) full.push_back(makeBody(cell.id, cell.species, cell.pose()));
  return full;
}

std::optional<TetrahedraSums> GrowthStage::tetrahedra() const {
  if (problem_.method.planeSource == PlaneSource::chords) return {};
  const Communicator& ranks = problem_.execution.communicator;
  TetrahedraSums sums = tetrahedra_;
  std::vector<std::int64_t> counts = {sums.runs, sums.attempts, sums.finer, sums.failures};
  ranks.sum(counts);
  sums.runs = counts[0];
  sums.attempts = counts[1];
  sums.finer = counts[2];
  sums.failures = counts[3];
  const std::vector<char> failures =
      ranks.gatherAll(std::vector<char>(sums.lastFailure.begin(), sums.lastFailure.end()));
  sums.lastFailure.assign(failures.begin(), failures.end());
  return sums;
}

/// On all ranks.
std::int64_t GrowthStage::countFull(const std::vector<Body>& cells) const {
  const std::vector<std::int64_t> full = countFullBySpecies(cells);
  return std::accumulate(full.begin(), full.end(), std::int64_t{0});
}

/// On all ranks.
std::vector<std::int64_t> GrowthStage::countFullBySpecies(const std::vector<Body>& cells) const {
  std::vector<std::int64_t> full(problem_.physics.species.size(), 0);
  for (const Body& cell : cells) full[cell.species] += cell.scale == 1.0;
  problem_.execution.communicator.sum(full);
  return full;
}

/// Whether there are as many full cells of each species as requested, or more from the reserve.
bool GrowthStage::complete(const std::vector<Body>& cells) const {
  const std::vector<std::int64_t> full = countFullBySpecies(cells);
  for (std::size_t s = 0; s < full.size(); ++s)
    if (full[s] < problem_.physics.species[s].count) return false;
  return true;
}

bool GrowthStage::anyReserve() const {
  const std::vector<std::int64_t>& reserve = problem_.method.escape->reserve;
  return std::any_of(reserve.begin(), reserve.end(), [](std::int64_t cells) { return cells > 0; });
}

/// Swapping may gain volume from full cells that become smaller: if that reduces the volume of the full
/// cells, the state is left unchanged.
void GrowthStage::escapeFromBest() {
  std::vector<Body> state = best_;
  const PlaneFunctionFactory factory = [this] {
    return makePlaneFunction(problem_.method.planeSource, physics_, execution_, tetrahedra_);
  };
  const auto observe = [this](const std::vector<Body>& now) {
    if (problem_.execution.observe) problem_.execution.observe(placed(now));
  };
  statistics_.escape = escape(
      physics_, execution_, problem_.method.growth, *problem_.method.escape, factory,
      [this] { return stopped(); }, observe, state);
  if (fullVolume(state) >= fullVolume(best_)) best_ = bySpecies(state);
}

/// Numbered by species, then by id. Pre: ids 0 ... cells - 1
std::vector<Body> GrowthStage::bySpecies(const std::vector<Body>& cells) const {
  const Communicator& ranks = problem_.execution.communicator;
  const IdShares shares(ranks.sum(static_cast<std::int64_t>(cells.size())), ranks);
  std::vector<Body> numbered = bodiesOf(shares.collect(cells));
  std::vector<std::int64_t> counts(problem_.physics.species.size(), 0);
  for (const Body& cell : numbered) ++counts[cell.species];
  std::vector<std::int64_t> next = ranks.sumBefore(counts);
  ranks.sum(counts);
  for (std::size_t s = 1; s < next.size(); ++s)
    next[s] +=
        std::accumulate(counts.begin(), counts.begin() + static_cast<std::ptrdiff_t>(s), std::int64_t{0});
  for (Body& cell : numbered) cell = makeBody(next[cell.species]++, cell.species, cell.pose());
  std::sort(numbered.begin(), numbered.end(), [](const Body& a, const Body& b) { return a.id < b.id; });
  return numbered;
}

/// Of the full cells on all ranks.
double GrowthStage::fullVolume(const std::vector<Body>& cells) const {
  const std::vector<std::int64_t> full = countFullBySpecies(cells);
  double volume = 0.0;
  for (std::size_t s = 0; s < full.size(); ++s)
    volume += static_cast<double>(full[s]) * physics_.species[s].shape->volume();
  return volume;
}

std::vector<PlacedCell> GrowthStage::placed(const std::vector<Body>& cells) const {
  std::vector<PlacedCell> placed;
  for (const Body& cell : cells) placed.push_back({cell.species, physics_.placement(cell.pose())});
  return placed;
}

}  // namespace packmesh
