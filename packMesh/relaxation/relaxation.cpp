// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/relaxation.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "packMesh/certificate/certificate.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/parallel/per_thread.h"

namespace packmesh {
namespace {

/// Verlet skin of the neighbour list [fraction of the largest radius]: wide while cells move fast, thin when
/// they are nearly at rest.
constexpr double thinnestSkin = 0.05, widestSkin = 0.2;

/// A list that was valid for fewer sweeps than `shortLived` is followed by one with a wider skin, one that
/// was valid for longer by one with a thinner skin.
constexpr std::int64_t shortLived = 4, longLived = 30;

/// Interval [sweeps] at which the motion of the cells is measured, which determines the margin beyond contact
/// within which pairs are tested: the displacement in some sweeps, within bounds [µm].
constexpr std::int64_t foreseenFor = 10;
constexpr double foreseenSweeps = 5.0;
constexpr double smallestMotion = 0.01, largestMotion = 0.25;

/// The first sweeps use coarse samples only, as long as contacts are deeper than this on average [fraction of
/// the largest radius].
constexpr double coarseDepth = 0.015;
/// Displacement of cells at which the neighbour list is rebuilt, as long as the list may miss some contacts:
/// while coarse samples suffice [fraction of the largest radius], and after that [fraction of the skin].
constexpr double coarseDisplacement = 0.8, fineDisplacement = 1.0;
/// If no contact may be missed: the sum of two displacements stays within the skin.
constexpr double completeDisplacement = 0.5;

/// If the deepest contact of a sweep was less than this, the next one examines all pairs completely [µm].
constexpr double nearlyResolved = 3.0 * tolerance::relaxationTolerance;

/// Edge of a block [multiples of the largest radius]: some 100-200 cells at typical volume fractions.
constexpr double preferredBlockEdge = 6.5;

/// If there are few cells, blocks are enlarged so that there is one for this many cells.
constexpr double fewestPerBlock = 50.0;

/// Blocks are redistributed among the ranks if the load of one of them exceeds the mean by this factor.
constexpr double tolerableImbalance = 1.02;

/// Cost of a cell, in units of the cost of a pair.
constexpr std::int64_t workOfCell = 4;

/// The second cell of a pair is loaded into the cache this many pairs before it is needed: cells lie anywhere
/// in the memory of their own and the adjacent blocks.
constexpr std::size_t pairsAhead = 10;

void prefetch(const Body& body) {
  constexpr std::size_t cacheLine = 64;
  const char* begin = reinterpret_cast<const char*>(&body);
  for (std::size_t at = 0; at < sizeof(Body); at += cacheLine) __builtin_prefetch(begin + at);
}

double blockEdge(const Box& bounds, double largestRadius, const std::vector<std::int64_t>& counts) {
  const auto bodies = std::accumulate(counts.begin(), counts.end(), std::int64_t(0));
  const double perBody = bounds.volume() / static_cast<double>(bodies);  // infinite without bodies
  return std::max(preferredBlockEdge * largestRadius, std::cbrt(fewestPerBlock * perBody));
}

/// Number of cells per species on all ranks.
std::vector<std::int64_t> countsOf(const std::vector<Body>& bodies, std::size_t species,
                                   const Communicator& communicator) {
  std::vector<std::int64_t> counts(species, 0);
  for (const Body& b : bodies) ++counts[b.species];
  communicator.sum(counts);
  return counts;
}

RelaxationState begun(RelaxationState state, const Physics& physics, const std::vector<Body>& bodies,
                      const Communicator& communicator) {
  if (state.counts.empty()) state.counts = countsOf(bodies, physics.species.size(), communicator);
  return state;
}

/// Shape of the cell of median volume; nullptr if there are no cells.
const Shape* medianShape(const Physics& physics, const std::vector<std::int64_t>& counts) {
  std::vector<std::size_t> species(counts.size());
  std::iota(species.begin(), species.end(), 0);
  std::stable_sort(species.begin(), species.end(), [&](std::size_t a, std::size_t b) {
    return physics.species[a].shape->volume() < physics.species[b].shape->volume();
  });
  const std::int64_t all = std::accumulate(counts.begin(), counts.end(), std::int64_t(0));
  std::int64_t before = 0;
  for (const std::size_t s : species)
    if (before += counts[s]; before > all / 2) return physics.species[s].shape.get();
  return nullptr;
}

ContactSolver makeSolver(const Physics& physics, const std::vector<std::int64_t>& counts) {
  std::vector<SpeciesModel> models;
  const Shape* median = medianShape(physics, counts);
  const double reference = median != nullptr ? median->volume() : 1.0;
  for (const Species& species : physics.species)
    models.emplace_back(*species.shape, physics.wallOf(species), reference, species.freedom);
  double reach = 0.0;
  for (const SpeciesModel& model : models) reach = std::max(reach, model.radius);
  // Between two rebuilds of the lists, no point of a cell leaves the bounds by more than this.
  ContactSolver solver(std::move(models), physics.container->bounds().grownBy(3.0 * reach),
                       physics.container->period(), physics.clearance + tolerance::relaxationMargin,
                       physics.wallClearance + tolerance::relaxationMargin);
  solver.setMobile(physics.rotate);
  return solver;
}

double medianHalfThickness(const Physics& physics, const std::vector<std::int64_t>& counts) {
  const Shape* median = medianShape(physics, counts);
  return median != nullptr ? median->halfThickness() : 1.0;
}

double largestRadius(const Physics& physics) {
  double radius = 0.0;
  for (const Species& species : physics.species) radius = std::max(radius, species.shape->radius());
  return radius;
}

/// Distance from a cell's centre within which the certificate can look for neighbours [µm].
double certifiedRange(double reach, double clearance) {
  return 2.0 * (reach + Relaxation::certifiedMotion) + std::max(gapOfInterest, clearance);
}

}  // namespace

Relaxation::Relaxation(const Physics& physics, const Execution& execution, std::vector<Body> bodies,
                       const RelaxationState& state)
    : communicator_(execution.communicator),
      threads_(execution.threads),
      bounds_(physics.container->bounds()),
      period_(physics.container->period()),
      clearance_(physics.clearance + tolerance::relaxationMargin),
      state_(begun(state, physics, bodies, communicator_)),
      cellCount_(communicator_.sum(static_cast<std::int64_t>(bodies.size()))),
      solver_(makeSolver(physics, state_.counts)),
      halfThickness_(medianHalfThickness(physics, state_.counts)),
      largestRadius_(largestRadius(physics)),
      largestReach_(physics.largestReach()),
      blocks_(bounds_, period_,
              std::max((2.0 + 2.0 * widestSkin) * largestRadius_ + clearance_,
                       0.5 * certifiedRange(largestReach_, clearance_)),
              blockEdge(bounds_, largestRadius_, state_.counts)),
      shared_(communicator_, blocks_),
      bodies_(std::move(bodies)) {
  if (state_.skin <= 0.0) state_.skin = widestSkin * largestRadius_;
  for (const auto& [pair, extra] : state_.extraClearance)
    largestExtra_ = std::max(largestExtra_, static_cast<double>(extra));
  state_.blocks = blocks_.counts();
  for (const Species& species : physics.species) radii_.push_back(species.shape->radius());
  std::vector<std::int64_t> cellsOfBlock(blocks_.count(), 0);
  for (const Body& body : bodies_) ++cellsOfBlock[blocks_.blockOf(wrapped(body.position, bounds_, period_))];
  shareOut(std::move(cellsOfBlock));
  distribute();
}

void Relaxation::shareOut(std::vector<std::int64_t> workOfBlock) {
  shared_.balance(std::move(workOfBlock));
  blocksOfColour_.assign(BlockGrid::colours, {});
  for (int b = 0; b < blocks_.count(); ++b)
    if (shared_.owns(b)) blocksOfColour_[blocks_.colourOf(b)].push_back(b);
}

double Relaxation::largestDisplacement() const {
  PerThread<double> squares(threads_);
  forEachBody([&](std::size_t i, int thread) {
    squares[thread] = std::max(squares[thread], (bodies_[i].position - listedAt_[i]).squaredNorm());
  });
  double largest = 0.0;
  squares.forEach([&](double square) { largest = std::max(largest, square); });
  return std::sqrt(largest);
}

/// Whether the next sweep is to examine all pairs completely, unless coarse samples suffice.
bool Relaxation::nearlyResolvedBefore() const {
  return state_.sweeps == 0 || state_.last.deepest < nearlyResolved;
}

/// Whether coarse samples suffice for the next sweep.
bool Relaxation::coarseWillDo() const {
  return state_.coarsely && (state_.sweeps == 0 || state_.last.meanDepth() > coarseDepth * largestRadius_);
}

double Relaxation::allowedDisplacement() const {
  if (coarseWillDo()) return coarseDisplacement * largestRadius_;
  return (nearlyResolvedBefore() ? completeDisplacement : fineDisplacement) * state_.skin;
}

bool Relaxation::beginsAnew() const {
  return !listed_ || state_.sweeps - state_.listedInSweep >= longestLived ||
         displacement_ > allowedDisplacement();
}

/// Distance from a rank's blocks within which its sweeps and its certificate need all cells [µm].
double Relaxation::range() const {
  return std::max(2.0 * largestRadius_ + clearance_ + largestExtra_ + state_.skin,
                  certifiedRange(largestReach_, clearance_));
}

/// Sends this rank's bodies to the owners of their blocks, and ghosts to the ranks that need them. Pre: no
/// ghosts.
void Relaxation::distribute() {
  forEachBody([&](std::size_t i, int) {
    bodies_[i].position = wrapped(bodies_[i].position, bounds_, period_);
    bodies_[i].block = blocks_.blockOf(bodies_[i].position);
  });
  shared_.distribute(bodies_, range());
}

void Relaxation::refreshLists(bool sleeping) {
  const std::int64_t lasted = state_.sweeps - state_.listedInSweep;
  if (state_.sweeps > 0 && lasted < shortLived) state_.skin *= 1.5;
  if (lasted > longLived) state_.skin *= 0.7;
  state_.skin = std::clamp(state_.skin, thinnestSkin * largestRadius_, widestSkin * largestRadius_);
  movedBefore_ = 0.0;
  foreseenInSweep_ = state_.listedInSweep;
  expectMotion();
  movedBefore_ = 0.0;
  state_.listedInSweep = state_.sweeps;
  list_ = PairList();  // never two lists in memory at a time
  lister_.reset();

  dropCopies();
  if (!sleeping && isUneven()) shareOut(workOfBlock_);
  distribute();
  bodyStart_.assign(blocks_.count() + 1, 0);
  for (const Body& body : bodies_) ++bodyStart_[body.block + 1];
  for (int b = 0; b < blocks_.count(); ++b) bodyStart_[b + 1] += bodyStart_[b];

  listedAt_.resize(bodies_.size());
  forEachBody([&](std::size_t i, int) {
    Body& body = bodies_[i];
    body.forgetSurroundings();
    body.sleeping = sleeping && state_.disturbed.count(body.id) == 0;
    listedAt_[i] = body.position;
  });
  mayBeDeep_ = coarseWillDo() || state_.last.deepest > deepContact;
  lister_.emplace(PairListerInput{bodies_, bodyStart_, radii_, clearance_ + largestExtra_ + state_.skin,
                                  bounds_, period_});
  list_.resize(blocks_.count());
  isListed_.assign(blocks_.count(), false);
  if (!communicator_.alone()) {
    isShared_ = shared_.shared(bodies_.size());
    atBorder_.assign(blocks_.count(), false);
  }
  listed_ = true;
  displacement_ = 0.0;
  if (sleeping) return;
  for (const std::vector<int>& colour : blocksOfColour_) listPairs(colour);
  lister_.reset();
  recordWork();
}

/// Lists the pairs of blocks, unless they are listed already.
void Relaxation::listPairs(std::vector<int> blocks) {
  if (!lister_) return;
  blocks.erase(std::remove_if(blocks.begin(), blocks.end(), [&](int b) { return isListed_[b] != 0; }),
               blocks.end());
  lister_->list(blocks, threads_, list_);
  threads_.forEach(static_cast<std::int64_t>(blocks.size()), [&](std::int64_t b, int) {
    isListed_[blocks[b]] = true;
    for (ContactPair& p : list_[blocks[b]]) {
      p.deep = mayBeDeep_;
      if (bodies_[p.first].sleeping && bodies_[p.second].sleeping) p.apartUntil = 0.0f;
      if (state_.extraClearance.empty()) continue;
      const auto extra = state_.extraClearance.find({bodies_[p.first].id, bodies_[p.second].id});
      if (extra != state_.extraClearance.end()) p.extraClearance = extra->second;
    }
  });
  if (!communicator_.alone()) findBorder(blocks);
}

/// Records the work of this rank's blocks, of which all pairs are listed.
void Relaxation::recordWork() {
  if (communicator_.alone()) return;
  workOfBlock_.assign(blocks_.count(), 0);
  for (const std::vector<int>& colour : blocksOfColour_)
    for (const int b : colour)
      workOfBlock_[b] =
          static_cast<std::int64_t>(list_[b].size()) + workOfCell * (bodyStart_[b + 1] - bodyStart_[b]);
}

/// Determines which of these blocks could change a body that another rank holds.
void Relaxation::findBorder(const std::vector<int>& blocks) {
  const auto& shared = isShared_;
  for (const int b : blocks)
    atBorder_[b] = std::any_of(shared.begin() + bodyStart_[b], shared.begin() + bodyStart_[b + 1],
                               [](char is) { return is != 0; }) ||
                   std::any_of(list_[b].begin(), list_[b].end(),
                               [&](const ContactPair& p) { return shared[p.first] || shared[p.second]; });
}

/// Whether the load of a rank exceeds the mean by much.
bool Relaxation::isUneven() const {
  if (communicator_.alone() || workOfBlock_.empty()) return false;
  const std::int64_t own = std::accumulate(workOfBlock_.begin(), workOfBlock_.end(), std::int64_t(0));
  const double most = communicator_.max(static_cast<double>(own));
  return most > tolerableImbalance * static_cast<double>(communicator_.sum(own)) / communicator_.size();
}

/// Sets the expected relative displacement of two cells within some sweeps in the solver, from their recent
/// motion.
void Relaxation::expectMotion() {
  constexpr double stepsPerMicrometre = 0x1p20;
  std::int64_t steps = 0;
  for (const Body& body : bodies_)
    if (owns(body)) steps += static_cast<std::int64_t>(body.moved * stepsPerMicrometre);
  const double all = static_cast<double>(communicator_.sum(steps)) / stepsPerMicrometre;
  const auto since = static_cast<double>(std::max<std::int64_t>(1, state_.sweeps - foreseenInSweep_));
  const double perSweep =
      (all - movedBefore_) / (since * static_cast<double>(std::max<std::int64_t>(1, cellCount_)));
  solver_.setExpectedMotion(std::clamp(foreseenSweeps * 2.0 * perSweep, smallestMotion, largestMotion));
  movedBefore_ = all;
  foreseenInSweep_ = state_.sweeps;
}

void Relaxation::activateAll() {
  active_.assign(blocks_.count(), true);
}

/// Whether the next sweep, with this slack, has to process only what was demanded since the last one, which
/// resolved everything.
bool Relaxation::isSleeping(double slack) const {
  return state_.sweeps > 0 && state_.last.thorough && slack >= state_.slack &&
         state_.last.deepest <= tolerance::relaxationTolerance - state_.slack;
}

void Relaxation::activateDisturbed() {
  if (state_.disturbed.empty()) return;
  for (const Body& body : bodies_)
    if (state_.disturbed.count(body.id)) activate(body.block);
  state_.disturbed.clear();
}

/// A cell of this block, or one near it, has moved.
void Relaxation::activate(int block) {
  for (const int b : blocks_.around(block)) active_[b] = true;
}

SweepSums Relaxation::sweep(double omega, double slack) {
  const bool sleeping = isSleeping(slack);
  if (slack < state_.slack) listed_ = false;  // pairs that were apart may now touch
  if (beginsAnew()) {
    refreshLists(sleeping);
    active_.assign(blocks_.count(), !sleeping);
  } else if (state_.sweeps - foreseenInSweep_ >= foreseenFor) {
    expectMotion();
  }
  activateDisturbed();
  forEachBody([&](std::size_t i, int) { bodies_[i].overlap = 0.0; });
  SweepSums sums;
  solver_.setPush(omega, slack);
  const bool coarsely = coarseWillDo();
  sums.thorough = nearlyResolvedBefore() && !coarsely;
  solver_.setThoroughly(sums.thorough);
  if (slack < state_.slack || coarsely != state_.coarsely) activateAll();
  state_.slack = slack;
  state_.coarsely = coarsely;
  solver_.setCoarsely(state_.coarsely);
  for (int colour = 0; colour < BlockGrid::colours; ++colour) {
    if (!blocks_.has(colour)) continue;
    listActive(colour);
    // Changes are sent as early as possible, so that no rank waits.
    resolve(colour, true, sums);
    shared_.beginGhostUpdate(bodies_);
    resolve(colour, false, sums);
    for (const int block : shared_.finishGhostUpdate(bodies_)) activate(block);
  }
  shared_.awaitGhostUpdate();
  displacement_ = largestDisplacement();
  if (!communicator_.alone()) addUp(sums);
  ++state_.sweeps;
  state_.last = sums;
  return sums;
}

/// Lists the pairs of the blocks of a colour that are about to be resolved.
void Relaxation::listActive(int colour) {
  if (!lister_) return;
  std::vector<int> blocks;
  for (const int block : blocksOfColour_[colour])
    if (active_[block]) blocks.push_back(block);
  listPairs(std::move(blocks));
}

/// Resolves the contacts of the blocks of a colour that are, or are not, at the border, as far as they can
/// have changed.
void Relaxation::resolve(int colour, bool border, SweepSums& sums) {
  due_.clear();
  for (const int block : blocksOfColour_[colour])
    if (atBorder(block) == border && std::exchange(active_[block], false)) due_.push_back(block);
  PerThread<SweepSums> of(threads_);
  threads_.forEach(static_cast<std::int64_t>(due_.size()), [&](std::int64_t i, int thread) {
    SweepSums found;
    resolve(due_[i], found);
    if (found.contacts == 0) due_[i] = none;
    of[thread].add(found);
  });
  of.forEach([&](const SweepSums& found) { sums.add(found); });
  for (const int block : due_)
    if (block != none) activate(block);
}

void Relaxation::resolve(int block, SweepSums& sums) {
  std::vector<ContactPair>& pairs = list_[block];
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (k + pairsAhead < pairs.size()) prefetch(bodies_[pairs[k + pairsAhead].second]);
    solver_.resolve(pairs[k], bodies_, sums);
  }
  for (std::int64_t i = bodyStart_[block]; i < bodyStart_[block + 1]; ++i)
    solver_.resolveSurroundings(bodies_[i], sums);
}

/// Over all ranks: the sums of a sweep and the displacement of the cells.
void Relaxation::addUp(SweepSums& sums) {
  std::vector<std::int64_t> added = {sums.totalSteps, sums.contacts};
  std::vector<double> largest = {sums.deepest, displacement_};
  communicator_.sumAndMax(added, largest);
  sums.totalSteps = added[0];
  sums.contacts = added[1];
  sums.deepest = largest[0];
  displacement_ = largest[1];
}

void Relaxation::demandClearance(std::int64_t first, std::int64_t second, double extra) {
  float& demanded = state_.extraClearance[std::minmax(first, second)];
  const double most =  // a larger one would exceed the neighbouring blocks
      blocks_.largestRange() - (2.0 + widestSkin) * largestRadius_ - clearance_;
  demanded = static_cast<float>(std::min(demanded + extra, most));
  largestExtra_ = std::max(largestExtra_, static_cast<double>(demanded));
  listed_ = false;
  state_.disturbed.insert(first);
  state_.disturbed.insert(second);
}

void Relaxation::demandWallClearance(std::int64_t id, double extra) {
  for (Body& body : bodies_)
    if (body.id == id) {
      body.extraWallClearance += extra;
      body.awayFromWallUntil = body.wallMaskUntil = -1.0;
      body.sleeping = false;
    }
  state_.disturbed.insert(id);
}

void Relaxation::remove(const std::vector<std::int64_t>& ids) {
  const auto gone = [&](const Body& body) { return std::binary_search(ids.begin(), ids.end(), body.id); };
  bodies_.erase(std::remove_if(bodies_.begin(), bodies_.end(), gone), bodies_.end());
  cellCount_ = communicator_.sum(static_cast<std::int64_t>(
      std::count_if(bodies_.begin(), bodies_.end(), [&](const Body& b) { return owns(b); })));
  listed_ = false;
}

void Relaxation::dropLists() {
  list_ = PairList();
  lister_.reset();
  listed_ = false;
  dropCopies();
  distribute();
}

void Relaxation::dropCopies() {
  bodies_.erase(std::remove_if(bodies_.begin(), bodies_.end(), [&](const Body& b) { return !owns(b); }),
                bodies_.end());
}

std::vector<Body> Relaxation::cells() const {
  return cellsThat([&](const Body& body) { return owns(body); });
}

std::vector<Body> Relaxation::cellsAround() const {
  return cellsThat([](const Body&) { return true; });
}

std::vector<Body> Relaxation::touchedCells() const {
  return cellsThat([&](const Body& body) { return body.touched && owns(body); });
}

void Relaxation::forgetTouched() {
  for (Body& body : bodies_) body.touched = false;
}

/// Sorted by id, positions wrapped into the bounds.
std::vector<Body> Relaxation::cellsThat(const std::function<bool(const Body&)>& fit) const {
  std::vector<const Body*> order;
  for (const Body& body : bodies_)
    if (fit(body)) order.push_back(&body);
  std::sort(order.begin(), order.end(), [](const Body* a, const Body* b) { return a->id < b->id; });
  std::vector<Body> cells;
  cells.reserve(order.size());
  for (const Body* body : order) {
    cells.push_back(*body);
    cells.back().position = wrapped(body->position, bounds_, period_);
  }
  return cells;
}

}  // namespace packmesh
