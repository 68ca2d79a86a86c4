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

RelaxationState begun(RelaxationState state, const Physics& physics, const std::vector<Body>& bodies,
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
      state_(begun(state, physics, bodies, communicator_)),
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

}  // namespace packmesh
