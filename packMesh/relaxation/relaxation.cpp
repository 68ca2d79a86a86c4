// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/relaxation.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "packMesh/certificate/certificate.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/mesh_intersection.h"

namespace packmesh {
namespace {

/// Edge of a block [multiples of the largest radius]: some 100-200 cells at typical volume fractions.
constexpr double preferredBlockEdge = 6.5;

/// If there are few cells, blocks are enlarged so that there is one for this many cells.
constexpr double fewestPerBlock = 50.0;

double blockEdge(const Box& bounds, double largestRadius, const std::vector<std::int64_t>& counts) {
  const auto bodies = std::accumulate(counts.begin(), counts.end(), std::int64_t(0));
  const double perBody = bounds.volume() / static_cast<double>(bodies);  // infinite without bodies
  return std::max(preferredBlockEdge * largestRadius, std::cbrt(fewestPerBlock * perBody));
}

/// Number of cells per shape on all ranks.
std::vector<std::int64_t> countsOf(const std::vector<Body>& bodies, std::size_t shapes,
                                   const Communicator& communicator) {
  std::vector<std::int64_t> counts(shapes, 0);
  for (const Body& b : bodies) ++counts[b.shape];
  communicator.sum(counts);
  return counts;
}

RelaxationState initialState(RelaxationState state, const Physics& physics, const std::vector<Body>& bodies,
                             const Communicator& communicator) {
  if (state.counts.empty()) state.counts = countsOf(bodies, physics.shapes.size(), communicator);
  return state;
}

/// Shape of the cell of median volume; nullptr if there are no cells.
const Shape* medianShape(const Physics& physics, const std::vector<std::int64_t>& counts) {
  std::vector<std::size_t> shapes(counts.size());
  std::iota(shapes.begin(), shapes.end(), 0);
  std::stable_sort(shapes.begin(), shapes.end(), [&](std::size_t a, std::size_t b) {
    return physics.shapes[a]->volume() < physics.shapes[b]->volume();
  });
  const std::int64_t all = std::accumulate(counts.begin(), counts.end(), std::int64_t(0));
  std::int64_t before = 0;
  for (const std::size_t s : shapes)
    if (before += counts[s]; before > all / 2) return physics.shapes[s].get();
  return nullptr;
}

ContactSolver makeSolver(const Physics& physics, const std::vector<std::int64_t>& counts) {
  std::vector<ShapeModel> shapes;
  std::vector<SpeciesModel> species;
  const Shape* median = medianShape(physics, counts);
  const double reference = median != nullptr ? median->volume() : 1.0;
  for (const auto& shape : physics.shapes) shapes.emplace_back(*shape, reference);
  for (const Species& one : physics.species) species.push_back({physics.wallOf(one), one.freedom});
  ContactSolver solver(std::move(shapes), std::move(species), physics.surroundings(),
                       physics.container->period(), physics.clearance + tolerance::relaxationMargin,
                       physics.wallClearance + tolerance::relaxationMargin);
  solver.setMobile(physics.rotate);
  return solver;
}

double medianHalfThickness(const Physics& physics, const std::vector<std::int64_t>& counts) {
  const Shape* median = medianShape(physics, counts);
  return median != nullptr ? median->halfThickness() : 1.0;
}

/// Distance from a cell's centre within which the certificate can look for neighbours [µm].
double certifiedRange(double reach, double clearance) {
  return 2.0 * (reach + Relaxation::certifiedMotion) + measuredUpTo(clearance);
}

}  // namespace

Relaxation::Relaxation(const Physics& physics, const Execution& execution, std::vector<Body> bodies,
                       const RelaxationState& state)
    : communicator_(execution.communicator),
      threads_(execution.threads),
      bounds_(physics.container->bounds()),
      period_(physics.container->period()),
      clearance_(physics.clearance + tolerance::relaxationMargin),
      state_(initialState(state, physics, bodies, communicator_)),
      cellCount_(communicator_.sum(static_cast<std::int64_t>(bodies.size()))),
      solver_(makeSolver(physics, state_.counts)),
      halfThickness_(medianHalfThickness(physics, state_.counts)),
      largestRadius_(physics.largest(&Shape::radius)),
      largestReach_(physics.largest(&Shape::reach)),
      blocks_(bounds_, period_,
              std::max((2.0 + 2.0 * widestSkin) * largestRadius_ + clearance_,
                       0.5 * certifiedRange(largestReach_, clearance_)),
              blockEdge(bounds_, largestRadius_, state_.counts)),
      shared_(communicator_, blocks_),
      around_(blocks_.count()),
      bodies_(std::move(bodies)) {
  if (state_.skin <= 0.0) state_.skin = widestSkin * largestRadius_;
  for (const auto& [pair, extra] : state_.extraClearance)
    largestExtra_ = std::max(largestExtra_, static_cast<double>(extra));
  state_.blocks = blocks_.counts();
  for (const auto& shape : physics.shapes) radii_.push_back(shape->radius());
  fixedCount_ = communicator_.sum(
      static_cast<std::int64_t>(std::count_if(bodies_.begin(), bodies_.end(), [&](const Body& body) {
        return physics.species[body.species].freedom.fixed;
      })));
  std::vector<std::int64_t> cellsOfBlock(blocks_.count(), 0);
  for (const Body& body : bodies_) ++cellsOfBlock[blocks_.blockOf(heldWithin(body.position))];
  shareOut(std::move(cellsOfBlock));
  distribute();
}

void Relaxation::demandClearance(std::int64_t first, std::int64_t second, double extra) {
  float& demanded = state_.extraClearance[std::minmax(first, second)];
  const double most =  // a diameter separates all cells; a larger one could exceed the neighbouring blocks
      std::min(2.0 * largestRadius_,
               blocks_.largestRange() - (2.0 + widestSkin) * largestRadius_ - clearance_);
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

std::vector<BodyState> Relaxation::states() const {
  return statesThat([&](const Body& body) { return owns(body); });
}

std::vector<BodyState> Relaxation::unsortedStates() const {
  std::vector<BodyState> states;
  states.reserve(bodies_.size());
  for (const Body& body : bodies_)
    if (owns(body)) states.push_back(wrappedState(body));
  return states;
}

std::vector<BodyState> Relaxation::statesAround() const {
  return statesThat([](const Body&) { return true; });
}

std::vector<BodyState> Relaxation::touchedStates() const {
  return statesThat([&](const Body& body) { return body.touched && owns(body); });
}

void Relaxation::forgetTouched() {
  for (Body& body : bodies_) body.touched = false;
}

/// Distance from a rank's blocks within which its sweeps and its certificate need all cells [µm].
double Relaxation::range() const {
  return std::max(2.0 * largestRadius_ + clearance_ + largestExtra_ + state_.skin,
                  certifiedRange(largestReach_, clearance_));
}

BodyState Relaxation::wrappedState(const Body& body) const {
  BodyState state = body;
  state.position = heldWithin(body.position);
  return state;
}

/// The image of a position in the period. Along other axes, cells that others have pushed out of the lumen
/// stay next to its bounds: the walls push them back.
Vec3 Relaxation::heldWithin(const Vec3& position) const {
  Vec3 held = wrapped(position, bounds_, period_);
  for (int k = 0; k < 3; ++k)
    if (!(period_[k] > 0.0))
      held[k] = std::clamp(held[k], bounds_.lo[k] - largestRadius_, bounds_.hi[k] + largestRadius_);
  return held;
}

/// Sorted by id, positions wrapped into the bounds.
template <class Fit>
std::vector<BodyState> Relaxation::statesThat(Fit&& fit) const {
  struct Key {
    std::int64_t id;
    std::int32_t index;
  };
  std::vector<Key> order;
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (fit(bodies_[i])) order.push_back({bodies_[i].id, static_cast<std::int32_t>(i)});
  std::sort(order.begin(), order.end(), [](const Key& a, const Key& b) { return a.id < b.id; });
  std::vector<BodyState> states(order.size());
  threads_.forEachPart(static_cast<std::int64_t>(order.size()),
                       [&](std::int64_t begin, std::int64_t end, int) {
                         for (std::int64_t k = begin; k < end; ++k)
                           states[k] = wrappedState(bodies_[order[k].index]);
                       });
  return states;
}

namespace {

/// Verlet skin of the neighbour list when cells are nearly at rest [fraction of the largest radius].
constexpr double thinnestSkin = 0.05;

/// A list that was valid for fewer sweeps than `shortLived` is followed by one with a wider skin, one that
/// was valid for longer by one with a thinner skin.
constexpr std::int64_t shortLived = 4, longLived = 30;

/// The margin beyond contact within which pairs are tested: the displacement of the cells in some sweeps,
/// within bounds [µm].
constexpr double foreseenSweeps = 5.0;
constexpr double smallestMotion = 0.01, largestMotion = 0.25;

/// Displacement of cells at which the neighbour list is rebuilt, as long as the list may miss some contacts:
/// while coarse samples suffice [fraction of the largest radius], and after that [fraction of the skin].
constexpr double coarseDisplacement = 0.8, fineDisplacement = 1.0;
/// If no contact may be missed: the sum of two displacements stays within the skin.
constexpr double completeDisplacement = 0.5;

/// Blocks are redistributed among the ranks if the load of one of them exceeds the mean by this factor.
constexpr double tolerableImbalance = 1.02;

/// Cost of a cell, in units of the cost of a pair.
constexpr std::int64_t workOfCell = 4;

}  // namespace

void Relaxation::shareOut(std::vector<std::int64_t> workOfBlock) {
  shared_.balance(std::move(workOfBlock));
  blocksOfColour_.assign(BlockGrid::colours, {});
  for (int b = 0; b < blocks_.count(); ++b)
    if (shared_.owns(b)) blocksOfColour_[blocks_.colourOf(b)].push_back(b);
}

double Relaxation::allowedDisplacement() const {
  if (coarseWillDo()) return coarseDisplacement * largestRadius_;
  return (nearlyResolvedBefore() ? completeDisplacement : fineDisplacement) * state_.skin;
}

bool Relaxation::rebuildsNext() const {
  return !listed_ || state_.sweeps - state_.listedInSweep >= longestLived ||
         displacement_ > allowedDisplacement();
}

/// Sends this rank's bodies to the owners of their blocks, and ghosts to the ranks that need them. Pre: no
/// ghosts.
void Relaxation::distribute() {
  forEachBody([&](std::size_t i, int) {
    bodies_[i].position = heldWithin(bodies_[i].position);
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
  forgetLists();  // never two lists in memory at a time

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
  orders_.resize(blocks_.count());
  stirred_.assign(blocks_.count(), true);
  displacements_.assign(blocks_.count(), 0.0);
  if (!communicator_.alone()) {
    exposed_.assign(bodies_.size(), 0);
    isShared_.assign(bodies_.size(), false);
    for (const std::int32_t i : shared_.shared()) isShared_[i] = true;
    exposedTo_ = {};
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

/// Determines which of these blocks, of one colour, could change a body that another rank holds, and those
/// bodies.
void Relaxation::findBorder(const std::vector<int>& blocks) {
  if (blocks.empty()) return;
  const int colour = blocks_.colourOf(blocks.front());
  const auto bit = static_cast<std::uint8_t>(1u << colour);
  for (const int b : blocks) {
    bool isAtBorder = false;
    const auto expose = [&](std::int64_t i) {
      if (!isShared_[i]) return;
      exposed_[i] |= bit;
      isAtBorder = true;
    };
    for (std::int64_t i = bodyStart_[b]; i < bodyStart_[b + 1]; ++i) expose(i);
    for (const ContactPair& p : list_[b]) expose(p.first), expose(p.second);
    atBorder_[b] = isAtBorder;
  }
  exposedTo_[colour].clear();
  for (const std::int32_t i : shared_.shared())
    if (exposed_[i] & bit) exposedTo_[colour].push_back(i);
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

void Relaxation::forgetLists() {
  list_ = PairList();
  orders_.clear();
  lister_.reset();
  listed_ = false;
}

void Relaxation::dropLists() {
  forgetLists();
  dropCopies();
  distribute();
}

void Relaxation::dropCopies() {
  bodies_.erase(std::remove_if(bodies_.begin(), bodies_.end(), [&](const Body& b) { return !owns(b); }),
                bodies_.end());
}

}  // namespace packmesh
