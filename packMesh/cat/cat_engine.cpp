// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/cat_engine.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "packMesh/cat/step_halving.h"
#include "packMesh/cat/tetgen_run.h"
#include "packMesh/core/error.h"
#include "packMesh/core/timer.h"
#include "packMesh/io/hdf5_file.h"
#include "packMesh/packing/cell_placing.h"
#include "packMesh/packing/problem_digest.h"
#include "packMesh/packing/state_file.h"

namespace packmesh {
namespace {

/// Number of stalls until an attempt gives up, except in the last attempt.
constexpr int stallsOfAttempt = 2;

/// Seeds of successive attempts differ by this.
constexpr std::uint64_t attemptStride = 0x9E3779B97F4A7C15u;

class CatStage : public EngineStage {
 public:
  CatStage(const PackingProblem& problem, const CatSettings& settings, RunControl& control,
           Statistics& statistics, std::function<void()> keep);

  bool run(std::int64_t iterations) override;
  bool ended() const override { return ended_; }
  bool hasBegun() const override { return growth_ != nullptr || bestFull_ >= 0; }
  std::int64_t iterations() const override { return statistics_->growth.iterations; }
  std::vector<Body> cells() const override;
  std::shared_ptr<const EngineState> save() const override;
  EngineCells take() override;

 private:
  void begin();
  void resume(const PackingState& state);
  std::vector<Body> fullCells() const;
  std::optional<TetrahedraSums> tetrahedra() const;
  void growFrom(std::vector<Body> cells, const GrowthProgress& from);
  void keepBest(std::vector<Body> cells);
  std::int64_t countFull(const std::vector<Body>& cells) const;
  std::vector<std::int64_t> countFullBySpecies(const std::vector<Body>& cells) const;
  bool complete(const std::vector<Body>& cells) const;
  bool anyReserve() const;
  void escapeFromBest();
  std::vector<Body> bySpecies(const std::vector<Body>& cells) const;
  double fullVolume(const std::vector<Body>& cells) const;
  std::vector<PlacedCell> placed(const std::vector<Body>& cells) const;
  bool stopped();

  const PackingProblem& problem_;
  const CatSettings& requested_;
  RunControl& control_;
  Statistics& all_;
  std::shared_ptr<CatStatistics> statistics_;
  std::function<void()> keep_;
  std::int64_t attempts_;
  Physics physics_;      ///< those of the problem, but with the seed of the present attempt
  Execution execution_;  ///< likewise, but interrupted at the time limit, too
  GrowthSettings settings_;
  GrowthCallbacks callbacks_;
  TetrahedraSums tetrahedra_;  ///< of this rank
  std::unique_ptr<PlaneFunction> planeFunction_;
  std::unique_ptr<Growth> growth_;
  std::int64_t attempt_ = 0;
  std::vector<Body> best_;      ///< of the attempts so far
  std::int64_t bestFull_ = -1;  ///< cells of full size in it, on all ranks
  bool ended_ = false;
};

void addGrowth(const GrowthSettings& settings, Digest& digest) {
  const auto& [initialScale, barriers, maxIterations, rotationBound, translationBound, padding,
               linearisations, alpha, beta, centring, shaking, patience, stalledGrowth, relaxationSweeps,
               giveUpAfter, attempts] = settings;
  for (const double barrier : barriers) digest.add(barrier);
  for (const double number :
       {initialScale, rotationBound, translationBound, padding, alpha, beta, shaking, stalledGrowth})
    digest.add(number);
  for (const int number :
       {maxIterations, linearisations, centring ? 1 : 0, patience, relaxationSweeps, giveUpAfter, attempts})
    digest.add(number);
}

void addEscape(const EscapeSettings& settings, Digest& digest) {
  const auto& [orientations, swapRounds, groupSize, holes, reserve] = settings;
  for (const int number : {orientations, swapRounds, groupSize, holes}) digest.add(number);
  for (const std::int64_t number : reserve) digest.add(number);
}

void checkStock(const EscapeSettings& escape, std::size_t species) {
  if (escape.reserve.size() > species)
    throw InputError("the reserve has bodies of more species than the problem");
  for (const std::int64_t bodies : escape.reserve)
    if (bodies < 0) throw InputError("the reserve has a negative number of bodies");
}

}  // namespace

CatStage::CatStage(const PackingProblem& problem, const CatSettings& settings, RunControl& control,
                   Statistics& statistics, std::function<void()> keep)
    : problem_(problem),
      requested_(settings),
      control_(control),
      all_(statistics),
      statistics_(std::make_shared<CatStatistics>()),
      keep_(std::move(keep)),
      attempts_(std::max<std::int64_t>(
          1, settings.growth.attempts / std::max<std::int64_t>(1, problem.physics.cellCount()))),
      physics_(problem.physics),
      execution_(problem.execution),
      settings_(settings.growth) {
  execution_.interrupted = [this] { return control_.stoppedHere(); };
  all_.engine = statistics_;
  planeFunction_ = makePlaneFunction(settings.planeSource, physics_, execution_, tetrahedra_);
  callbacks_.stop = [this] { return stopped(); };
  callbacks_.checkpoint = keep_;
  if (problem.execution.progress)
    callbacks_.progress = [this](double barrier, std::int64_t below, const GrowthStatistics& sums) {
      problem_.execution.progress({"growth", sums.iterations, barrier, 0.0, below});
    };
  if (problem.execution.observe)
    callbacks_.accepted = [this](const std::vector<Body>& now) { problem_.execution.observe(placed(now)); };
  if (problem.resume && problem.resume->position.stage == Stage::engine) resume(*problem.resume);
}

bool CatStage::stopped() {
  return control_.stopped() || iterations() >= problem_.execution.limits.maxSweeps;
}

bool CatStage::run(std::int64_t iterations) {
  while (!ended_) {
    if (!growth_) begin();
    if (!growth_) return false;  // no time was left for it
    const Timer watch(all_.engineSeconds);
    const bool full = growth_->run(iterations);
    if (!full && !growth_->ended()) return false;
    keepBest(growth_->cells());
    growth_.reset();
    ended_ = full || ++attempt_ == attempts_;
    if (ended_ && requested_.escape && (!full || anyReserve()) && !stopped()) escapeFromBest();
  }
  return complete(best_);
}

/// Places the initial cells of an attempt.
void CatStage::begin() {
  physics_.seed = problem_.physics.seed + static_cast<std::uint64_t>(attempt_) * attemptStride;
  const IdShares shares(problem_.physics.cellCount(), problem_.execution.communicator);
  std::vector<Body> cells;
  {
    const Timer watch(all_.placementSeconds);
    std::optional<std::vector<Body>> placed = placedCells(physics_, execution_, shares, control_);
    if (!placed) return;
    cells = std::move(*placed);
    std::vector<std::int64_t> first = {0};
    for (const Species& species : problem_.physics.species) first.push_back(first.back() + species.count);
    for (Body& cell : cells)
      if (!problem_.physics.species[cell.species].startsAtGivenPose(cell.id - first[cell.species]))
        cell.scale = settings_.initialScale;
    if (!seed(physics_, execution_, settings_.initialScale, callbacks_.stop, cells)) {
      ended_ = !stopped();
      return;
    }
  }
  growFrom(std::move(cells), {});
  keep_();
}

void CatStage::growFrom(std::vector<Body> cells, const GrowthProgress& from) {
  settings_.giveUpAfter = attempt_ + 1 < attempts_ ? stallsOfAttempt : requested_.growth.giveUpAfter;
  growth_ = std::make_unique<Growth>(physics_, execution_, settings_, *planeFunction_, callbacks_,
                                     std::move(cells), statistics_->growth, from);
}

void CatStage::resume(const PackingState& state) {
  const auto& of = dynamic_cast<const CatState&>(*state.engine);
  attempt_ = of.attempt;
  statistics_->growth.iterations = of.done;
  physics_.seed = problem_.physics.seed + static_cast<std::uint64_t>(attempt_) * attemptStride;
  keepBest(bodiesOf(of.best));
  growFrom(bodiesOf(state.cells), of.at);
}

std::shared_ptr<const EngineState> CatStage::save() const {
  auto state = std::make_shared<CatState>();
  state->attempt = attempt_;
  state->done = iterations();
  if (growth_) state->at = growth_->progress();
  state->at.gaveUp = false;
  state->best = IdShares(problem_.physics.cellCount(), problem_.execution.communicator).collect(best_);
  return state;
}

void CatState::write(Hdf5Writer& out, const Physics& physics, const std::vector<BodyState>& cells) const {
  EngineTables tables{{attempt, done, at.barrier, at.iteration, at.since, at.failures},
                      {at.sweeps, static_cast<double>(at.reference)},
                      {},
                      best};
  for (const BodyState& cell : cells) tables.taken.push_back(cell.stepTaken);
  tables.write(out, physics);
}

std::shared_ptr<const EngineState> CatEngine::readState(const Hdf5Reader& in, const PackingProblem& problem,
                                                        std::int64_t first,
                                                        std::vector<BodyState>& cells) const {
  EngineTables tables = EngineTables::read(in, problem, first, static_cast<std::int64_t>(cells.size()));
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i].stepTaken = tables.taken[i];
  auto state = std::make_shared<CatState>();
  const auto [attempt, done, barrier, iteration, since, failures] = tables.position;
  const auto [sweeps, reference] = tables.numbers;
  state->attempt = attempt;
  state->done = done;
  state->at = {barrier, iteration, since, failures, sweeps, static_cast<std::int64_t>(reference)};
  state->best = std::move(tables.best);
  return state;
}

std::vector<Body> CatStage::cells() const {
  return growth_ ? growth_->cells() : best_;
}

void CatStage::keepBest(std::vector<Body> cells) {
  const std::int64_t full = countFull(cells);
  if (full <= bestFull_) return;
  bestFull_ = full;
  best_ = std::move(cells);
}

std::vector<Body> CatStage::fullCells() const {
  std::vector<Body> now = cells(), full;
  if (countFull(now) <= bestFull_) now = best_;
  for (const Body& cell : now)
    if (cell.scale == 1.0) full.push_back(makeBody(cell.id, cell.species, cell.shape, cell.pose()));
  return full;
}

/// After an escape they are renumbered.
EngineCells CatStage::take() {
  statistics_->tetrahedra = tetrahedra();
  return {fullCells(), {}};
}

/// Of all ranks; empty for planes that need no tetrahedra.
std::optional<TetrahedraSums> CatStage::tetrahedra() const {
  if (requested_.planeSource == PlaneSource::chords) return {};
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
std::int64_t CatStage::countFull(const std::vector<Body>& cells) const {
  const std::vector<std::int64_t> full = countFullBySpecies(cells);
  return std::accumulate(full.begin(), full.end(), std::int64_t{0});
}

/// On all ranks.
std::vector<std::int64_t> CatStage::countFullBySpecies(const std::vector<Body>& cells) const {
  std::vector<std::int64_t> full(problem_.physics.species.size(), 0);
  for (const Body& cell : cells) full[cell.species] += cell.scale == 1.0;
  problem_.execution.communicator.sum(full);
  return full;
}

/// Whether there are as many full cells of each species as requested, or more from the reserve.
bool CatStage::complete(const std::vector<Body>& cells) const {
  const std::vector<std::int64_t> full = countFullBySpecies(cells);
  for (std::size_t s = 0; s < full.size(); ++s)
    if (full[s] < problem_.physics.species[s].count) return false;
  return true;
}

bool CatStage::anyReserve() const {
  const std::vector<std::int64_t>& reserve = requested_.escape->reserve;
  return std::any_of(reserve.begin(), reserve.end(), [](std::int64_t cells) { return cells > 0; });
}

/// Swapping may gain volume from full cells that become smaller: if that reduces the volume of the full
/// cells, the state is left unchanged.
void CatStage::escapeFromBest() {
  std::vector<Body> state = best_;
  const PlaneFunctionFactory factory = [this] {
    return makePlaneFunction(requested_.planeSource, physics_, execution_, tetrahedra_);
  };
  const auto observe = [this](const std::vector<Body>& now) {
    if (problem_.execution.observe) problem_.execution.observe(placed(now));
  };
  statistics_->escape = escape(
      physics_, execution_, requested_.growth, *requested_.escape, factory, [this] { return stopped(); },
      observe, state);
  if (fullVolume(state) >= fullVolume(best_)) best_ = bySpecies(state);
}

/// Numbered by species, then by id. Pre: ids 0 ... cells - 1
std::vector<Body> CatStage::bySpecies(const std::vector<Body>& cells) const {
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
  for (Body& cell : numbered) cell = makeBody(next[cell.species]++, cell.species, cell.shape, cell.pose());
  std::sort(numbered.begin(), numbered.end(), [](const Body& a, const Body& b) { return a.id < b.id; });
  return numbered;
}

/// Of the full cells on all ranks.
double CatStage::fullVolume(const std::vector<Body>& cells) const {
  std::vector<std::int64_t> full(physics_.shapes.size(), 0);
  for (const Body& cell : cells) full[cell.shape] += cell.scale == 1.0;
  problem_.execution.communicator.sum(full);
  double volume = 0.0;
  for (std::size_t s = 0; s < full.size(); ++s)
    volume += static_cast<double>(full[s]) * physics_.shapes[s]->volume();
  return volume;
}

std::vector<PlacedCell> CatStage::placed(const std::vector<Body>& cells) const {
  std::vector<PlacedCell> placed;
  for (const Body& cell : cells)
    placed.push_back({cell.species, cell.shape, physics_.placement(cell.pose())});
  return placed;
}

std::vector<std::string> CatStatistics::lines(const Statistics& all) const {
  const double seconds =
      growth.planeSeconds + growth.programSeconds + growth.stepHalvingSeconds + growth.relaxationSeconds;
  std::vector<std::string> lines = {
      fmt::format("Growth: {} iterations, {} relaxations after stalls ({} successful); {} of {} steps "
                  "overlapped another cell, {} the wall, {} were rejected",
                  growth.iterations, growth.relaxations, growth.relaxationsKept,
                  growth.stepHalving.violatingPairs, growth.stepHalving.steps, growth.stepHalving.misplaced,
                  growth.stepHalving.stayed),
      fmt::format("Growth, CPU: planes {:.3f} s, programmes {:.3f} s, exact tests and step halving {:.3f} s "
                  "({:.0f} %), relaxation {:.3f} s",
                  growth.planeSeconds, growth.programSeconds, growth.stepHalvingSeconds,
                  seconds > 0.0 ? 100.0 * growth.stepHalvingSeconds / seconds : 0.0,
                  growth.relaxationSeconds)};
  if (tetrahedra)
    lines.push_back(fmt::format(
        "Tetrahedra: {} runs, {} attempts of TetGen, {} repeated on finer levels, {} failures; CPU: {:.3f} "
        "s, CAT faces {:.3f} s",
        tetrahedra->runs, tetrahedra->attempts, tetrahedra->finer, tetrahedra->failures,
        tetrahedra->tetrahedraSeconds, tetrahedra->faceSeconds));
  if (tetrahedra && tetrahedra->failures > 0)
    lines.push_back("Tetrahedra, the last failure: " + tetrahedra->lastFailure);
  for (const EscapePhase& phase : escape)
    lines.push_back(fmt::format(
        "Escape, {}: coverage {:.4f}, {} of {} cells full; {} tried, {} changed; CPU {:.3f} s", phase.name,
        phase.coverage, phase.full, phase.cells, phase.tried, phase.changed, phase.seconds));
  lines.push_back(fmt::format("CPU: start {:.3f} s, growth {:.3f} s, certificate {:.3f} s",
                              all.placementSeconds, all.engineSeconds, all.certificateSeconds));
  return lines;
}

std::string CatStatistics::json() const {
  std::string phases;
  for (const EscapePhase& phase : escape)
    phases += fmt::format(
        R"({}{{"phase": "{}", "coverage": {}, "full": {}, "cells": {}, "tried": {}, "changed": {}}})",
        phases.empty() ? "" : ", ", phase.name, phase.coverage, phase.full, phase.cells, phase.tried,
        phase.changed);
  return fmt::format(
      R"({{"growth": {{"iterations": {}, "relaxations": {}, "relaxationsKept": {}}}, "escape": [{}]}})",
      growth.iterations, growth.relaxations, growth.relaxationsKept, phases);
}

void CatEngine::validate(const PackingProblem& problem) const {
  packmesh::validate(settings.growth);
  if (settings.escape) checkStock(*settings.escape, problem.physics.species.size());
  if (settings.escape || settings.planeSource == PlaneSource::catFaces)
    requireTetgen(problem.execution.communicator);
}

void CatEngine::addTo(Digest& digest) const {
  const auto& [planeSource, growth, escape] = settings;
  digest.add(static_cast<int>(planeSource));
  addGrowth(growth, digest);
  digest.add(escape.has_value());
  if (escape) addEscape(*escape, digest);
}

std::shared_ptr<EngineStatistics> CatEngine::statistics(std::int64_t iterations) const {
  auto statistics = std::make_shared<CatStatistics>();
  statistics->growth.iterations = iterations;
  return statistics;
}

std::unique_ptr<EngineStage> CatEngine::begin(const PackingProblem& problem, RunControl& control,
                                              Statistics& statistics, std::function<void()> keep) const {
  return std::make_unique<CatStage>(problem, settings, control, statistics, std::move(keep));
}

/// Without escapes; a trial that stalls is abandoned: fewer cells take less time than relaxations of hopeless
/// ones.
std::shared_ptr<const Engine> CatEngine::forTrials() const {
  auto trial = std::make_shared<CatEngine>(settings);
  trial->settings.escape.reset();
  if (trial->settings.growth.giveUpAfter == 0) trial->settings.growth.giveUpAfter = 1;
  return trial;
}

}  // namespace packmesh
