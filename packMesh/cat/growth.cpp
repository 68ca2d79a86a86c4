// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/growth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "packMesh/cat/growing_cells.h"
#include "packMesh/cat/levels_of_detail.h"
#include "packMesh/cat/step_halving.h"
#include "packMesh/core/error.h"
#include "packMesh/core/random.h"
#include "packMesh/core/timer.h"
#include "packMesh/core/tolerances.h"

namespace packmesh {
namespace {

/// Triangles larger than this [fraction of the cube root of the volume] are large because the surface is flat
/// there, and need no padding for their size.
constexpr double largestFacet = 0.1;

/// The state can be saved at this interval of iterations within a barrier: a multiple of any
/// PlaneFunction::lifetime().
constexpr std::int64_t iterationsPerCheckpoint = 4;

/// Factor by which the number of sweeps increases after each failed relaxation at a barrier.
constexpr double moreSweeps = 1.5;

/// Planes are constructed for this many cells at a time: all of them would take some 10 kB per cell. Pairs of
/// cells of different batches are visited twice. With threads there are a few batches for each, of so many
/// cells at least.
constexpr std::int64_t cellsPerBatch = 512, fewestPerBatch = 16, batchesPerThread = 4;

/// Neighbours are searched from the growing cells if those are less than this part of all; otherwise from the
/// others, which threads can share.
constexpr std::int64_t searchFromGrowing = 4;

/// Unit in which scales are summed as integers, so that the sum does not depend on the order.
constexpr double unitsOfScale = 0x1p24;

}  // namespace

Growth::Growth(const Physics& physics, const Execution& execution, const GrowthSettings& settings,
               PlaneFunction& planeFunction, const GrowthCallbacks& callbacks, std::vector<Body> own,
               GrowthStatistics& statistics, const GrowthProgress& from)
    : physics_(physics),
      execution_(execution),
      settings_(settings),
      planeFunction_(planeFunction),
      callbacks_(callbacks),
      statistics_(statistics),
      at_(from),
      lengths_(lengthsOf(physics)),
      // Blocks become larger than asked for, because a whole number of them has to fit.
      cells_(physics, execution, own, range(), planeFunction.cellsAtOnce() / 2),
      anyFrozen_(std::any_of(own.begin(), own.end(), [](const Body& cell) { return cell.frozen; })),
      stepHalving_(physics, execution),
      planes_(execution.threads),
      programs_(execution.threads) {
  requireValid();
}

std::vector<Growth::ShapeLengths> Growth::lengthsOf(const Physics& physics) {
  std::vector<ShapeLengths> lengths(physics.shapes.size());
  for (const int s : physics.shapesInUse()) {
    const Shape& shape = *physics.shapes[s];
    const double size = std::cbrt(shape.volume());
    const double meanArea = surfaceArea(shape.mesh()) / static_cast<double>(shape.mesh().triangles.size());
    lengths[s] = {shape.radius(), shape.reach(), size, std::min(std::sqrt(meanArea), largestFacet * size)};
  }
  return lengths;
}

/// Distance within which cells affect each other in one iteration [µm]: for planes and, after any step, for
/// the exact test.
double Growth::range() const {
  double reach = 0.0;
  for (std::size_t s = 0; s < lengths_.size(); ++s) {
    const double moved = static_cast<double>(planeFunction_.lifetime()) * farthest(1.0, lengths_[s]);
    reach = std::max(reach, lengths_[s].reach + moved + paddingAt(1.0, lengths_[s]));
  }
  return 2.0 * reach + physics_.clearance;
}

void Growth::requireValid() const {
  const Certificate faults = stepHalving_.examine(cells_);
  if (!faults.overlapping.empty())
    throw InputError("cells " + std::to_string(faults.overlapping[0].first) + " and " +
                     std::to_string(faults.overlapping[0].second) + " overlap before growth");
  if (!faults.misplaced.empty())
    throw InputError("cell " + std::to_string(faults.misplaced[0].cell) + " " + faults.misplaced[0].reason +
                     " before growth");
}

bool Growth::stopped(std::int64_t iterations) const {
  return statistics_.iterations >= iterations || (callbacks_.stop && callbacks_.stop());
}

bool Growth::ended() const {
  return at_.gaveUp || at_.barrier >= static_cast<std::int64_t>(settings_.barriers.size());
}

bool Growth::run(std::int64_t iterations) {
  while (!ended()) {
    const double barrier = settings_.barriers[at_.barrier];
    if (barrier > settings_.initialScale && !growTo(barrier, iterations)) break;
    if (at_.gaveUp) break;
    ++at_.barrier;
    at_.iteration = 0;
  }
  return missing(1.0).cells == 0;
}

Growth::Missing Growth::missing(double scale) const {
  std::vector<std::int64_t> sums = {0, 0};
  for (std::size_t i = 0; i < cells_.all().size(); ++i) {
    const Body& cell = cells_.all()[i];
    if (!cells_.isOwn(static_cast<std::int64_t>(i)) || cell.frozen || cell.scale >= scale) continue;
    ++sums[0];
    sums[1] += std::llround((scale - cell.scale) * unitsOfScale);
  }
  execution_.communicator.sum(sums);
  return {sums[0], sums[1]};
}

/// @return whether growth is done with this barrier; if false, it has to continue
bool Growth::growTo(double barrier, std::int64_t iterations) {
  if (at_.iteration == 0) {
    const Missing lacks = missing(barrier);
    if (lacks.cells == 0) return true;
    at_.reference = lacks.scale;
    at_.since = at_.failures = 0;
    at_.sweeps = settings_.relaxationSweeps;
  }
  while (at_.iteration < settings_.maxIterations) {
    if (stopped(iterations)) return false;
    if (callbacks_.checkpoint && at_.iteration % iterationsPerCheckpoint == 0) callbacks_.checkpoint();
    iterate(barrier);
    ++at_.iteration;
    const Missing lacks = missing(barrier);
    if (callbacks_.progress) callbacks_.progress(barrier, lacks.cells, statistics_);
    if (lacks.cells == 0) return true;
    if (++at_.since < settings_.patience) continue;
    const bool stalled = static_cast<double>(lacks.scale) >
                         (1.0 - settings_.stalledGrowth) * static_cast<double>(at_.reference);
    at_.reference = lacks.scale;
    at_.since = 0;
    if (!stalled) continue;
    if (at_.sweeps > 0.0 && !anyFrozen_ && relaxed(barrier)) return true;
    at_.sweeps *= moreSweeps;
    at_.gaveUp = ++at_.failures == settings_.giveUpAfter;
    if (at_.gaveUp) return true;
  }
  // In large packings the last cells approach the barrier very slowly.
  if (at_.sweeps > 0.0 && !anyFrozen_) relaxed(barrier);
  return true;
}

void Growth::iterate(double barrier) {
  const bool anew = at_.iteration % planeFunction_.lifetime() == 0;
  if (anew) {
    cells_.distribute();
    const std::int64_t atOnce = planeFunction_.cellsAtOnce();
    batches_ = atOnce > 0 ? cells_.partsOfBlocks(atOnce) : cells_.batches(batchSize());
  }
  std::vector<GrowthStep> steps(cells_.all().size());
  const CellSurroundings surroundings = surroundingsFor(barrier);
  propose(surroundings, barrier, anew, steps);
  {
    const Timer watch(statistics_.stepHalvingSeconds);
    StepHalvingSums own;
    stepHalving_.take(steps, surroundings, cells_, own);
    std::vector<std::int64_t> sums = {own.steps, own.violatingPairs, own.misplaced, own.stayed};
    execution_.communicator.sum(sums);
    StepHalvingSums& all = statistics_.stepHalving;
    all.steps += sums[0];
    all.violatingPairs += sums[1];
    all.misplaced += sums[2];
    all.stayed += sums[3];
  }
  ++statistics_.iterations;
  if (callbacks_.accepted) callbacks_.accepted(cells_.own());
}

std::size_t Growth::batchSize() const {
  if (execution_.threads.alone()) return cellsPerBatch;
  const auto cells = static_cast<std::int64_t>(cells_.all().size());
  return std::clamp(cells / (batchesPerThread * execution_.threads.count()), fewestPerBatch, cellsPerBatch);
}

/// If few cells are still below the barrier, the others stay, except for those that could make space. While
/// data about the surroundings is reused, no others wake up.
void Growth::wake(double barrier, const CellSurroundings& surroundings) {
  const std::vector<Body>& cells = cells_.all();
  std::vector<std::int64_t> growing;
  std::int64_t fixed = 0;
  awake_.assign(cells.size(), 0);
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (isFixed(physics_, cells[i])) {
      ++fixed;
    } else if (cells[i].scale < barrier) {
      awake_[i] = 1;
      growing.push_back(static_cast<std::int64_t>(i));
    }
  const auto all = static_cast<std::int64_t>(cells.size()), grow = static_cast<std::int64_t>(growing.size());
  if (grow + fixed == all) return;
  if (grow < all / searchFromGrowing) {
    for (const NearPair& pair : surroundings.pairsOf(growing))
      for (const std::int64_t i : {pair.first, pair.second}) awake_[i] = !isFixed(physics_, cells[i]);
    return;
  }
  const std::vector<char> marked = awake_;
  execution_.threads.forEachPart(all, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i)
      if (!marked[i] && !isFixed(physics_, cells[i])) awake_[i] = surroundings.isNear(i, marked);
  });
}

CellSurroundings Growth::surroundingsFor(double barrier) const {
  const std::vector<Body>& cells = cells_.all();
  std::vector<double> reach(cells.size()), extent(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const ShapeLengths& l = lengths_[cells[i].shape];
    reach[i] = reachOf(cells[i], barrier);
    const double farthest = std::sqrt(3.0) * settings_.translationBound * l.size;
    extent[i] = std::max(cells[i].scale, barrier) * l.reach + farthest + tolerance::culling;
  }
  return {physics_, cells, std::move(reach), std::move(extent)};
}

/// The step of each cell of this rank within its planes.
void Growth::propose(const CellSurroundings& surroundings, double barrier, bool anew,
                     std::vector<GrowthStep>& steps) {
  const Timer watch;
  const std::vector<Body>& cells = cells_.all();
  if (anew) wake(barrier, surroundings);
  std::vector<PlaneRequest> requests;
  for (std::size_t batch = 0; batch < batches_.size(); ++batch) {
    requests.push_back({surroundings, {}, detailAt(barrier), largestMotion(barrier), batch, anew});
    for (const std::int64_t i : batches_[batch])
      if (awake_[i]) requests.back().wanted.push_back(i);
  }
  if (anew) planeFunction_.begin(requests);
  for (std::size_t i = 0; i < cells.size(); ++i) steps[i].scale = cells[i].scale;
  PerThread<ProposalSums> sums(execution_.threads);
  std::vector<std::int32_t> work(cells.size(), 0);
  execution_.threads.forEach(static_cast<std::int64_t>(batches_.size()), [&](std::int64_t batch, int thread) {
    requests[batch].thread = thread;
    proposeFor(requests[batch], barrier, steps, work, sums[thread]);
  });
  for (std::size_t i = 0; i < cells.size(); ++i) cells_.addWork(static_cast<std::int64_t>(i), work[i]);
  std::vector<std::int64_t> counts = {0, 0};
  double programSeconds = 0.0;
  sums.forEach([&](const ProposalSums& of) {
    counts[0] += of.planes;
    counts[1] += of.pivots;
    programSeconds += of.programSeconds;
  });
  statistics_.programSeconds += programSeconds;
  statistics_.planeSeconds += watch.cpu() - programSeconds;
  execution_.communicator.sum(counts);
  statistics_.planes += counts[0];
  statistics_.pivots += counts[1];
}

/// The steps of the cells of a batch.
/// @param work set for each of these cells, see GrowingCells::addWork()
void Growth::proposeFor(const PlaneRequest& request, double barrier, std::vector<GrowthStep>& steps,
                        std::vector<std::int32_t>& work, ProposalSums& sums) {
  const std::vector<Body>& cells = cells_.all();
  std::vector<CellPlanes>& planes = planes_[request.thread];
  if (planes.size() < request.wanted.size()) planes.resize(request.wanted.size());
  for (CellPlanes& of : planes) of.clear();
  planeFunction_(request, planes);
  GrowthProgram& program = programs_[request.thread];
  const ThreadTimer watch(sums.programSeconds);
  sums.pivots -= program.pivots();
  for (std::size_t k = 0; k < request.wanted.size(); ++k) {
    const std::int64_t i = request.wanted[k];
    steps[i] = program.solve(cells[i].pose(), planes[k], boundsOf(cells[i], barrier));
    work[i] = 1 + static_cast<std::int32_t>(planes[k].size());
    sums.planes += static_cast<std::int64_t>(planes[k].size());
  }
  sums.pivots += program.pivots();
}

double Growth::detailAt(double barrier) const {
  const double first = settings_.initialScale;
  return resamplingFactor((barrier - first) / (1.0 - first), settings_.alpha, settings_.beta);
}

/// p of eq. 3.10 [µm].
double Growth::paddingAt(double barrier, const ShapeLengths& lengths) const {
  return settings_.padding * barrier * lengths.facet / std::sqrt(detailAt(barrier));
}

/// Upper bound of the displacement of any point of a cell in one iteration without growth [µm].
double Growth::farthest(double barrier, const ShapeLengths& lengths) const {
  return std::sqrt(3.0) *
         (settings_.translationBound * lengths.size + rotationBound() * barrier * lengths.radius);
}

/// Largest expected displacement of points in one iteration without growth [µm].
double Growth::largestMotion(double barrier) const {
  double largest = 0.0;
  for (const ShapeLengths& l : lengths_)
    largest = std::max(largest, planeFunction_.expectedShare() * farthest(barrier, l));
  return largest;
}

/// Expected displacement of the points of a cell in one iteration, by which planes are padded [µm].
double Growth::reachOf(const Body& cell, double barrier) const {
  const ShapeLengths& l = lengths_[cell.shape];
  return planeFunction_.expectedShare() * farthest(barrier, l) +
         std::max(0.0, barrier - cell.scale) * l.radius + paddingAt(barrier, l);
}

GrowthBounds Growth::boundsOf(const Body& cell, double barrier) const {
  const ShapeLengths& l = lengths_[cell.shape];
  GrowthBounds bounds;
  // A cell whose step was shortened moves away first: otherwise the same step would be proposed again.
  bounds.scale = cell.stepTaken < 1.0 ? cell.scale : std::max(barrier, cell.scale);
  bounds.rotation = rotationBound();
  bounds.translation = settings_.translationBound * l.size;
  bounds.padding = paddingAt(barrier, l) + 0.5 * physics_.clearance;
  bounds.linearisations = settings_.linearisations;
  if (settings_.centring) bounds.margin = bounds.translation;
  if (physics_.rotate) bounds.cone = physics_.species[cell.species].freedom.cone;
  // Random pushes are scaled by the growth that they could cost: per µm for translations, per rad for
  // rotations.
  const auto id = static_cast<std::uint64_t>(cell.id);
  const auto iteration = static_cast<std::uint32_t>(statistics_.iterations);
  const auto u = uniform4(physics_.seed, RandomStream::turn, id, iteration);
  const auto v = uniform4(physics_.seed, RandomStream::kick, id, iteration);
  bounds.turn = settings_.shaking * uniformDirection(u[0], u[1]);
  bounds.push = settings_.shaking / l.radius * uniformDirection(v[0], v[1]);
  return bounds;
}

bool Growth::relaxed(double barrier) {
  ++statistics_.relaxations;
  bool kept = false;
  {
    const Timer watch(statistics_.relaxationSeconds);
    kept = relaxAtScale(physics_, execution_, barrier, static_cast<int>(at_.sweeps), callbacks_.stop, cells_);
  }
  statistics_.relaxationsKept += kept;
  if (kept && callbacks_.accepted) callbacks_.accepted(cells_.own());
  return kept;
}

bool grow(const Physics& physics, const Execution& execution, const GrowthSettings& settings,
          PlaneFunction& planeFunction, const GrowthCallbacks& callbacks, std::vector<Body>& own,
          GrowthStatistics& statistics) {
  Growth growth(physics, execution, settings, planeFunction, callbacks, own, statistics);
  const bool full = growth.run(std::numeric_limits<std::int64_t>::max());
  own = growth.cells();
  return full;
}

}  // namespace packmesh
