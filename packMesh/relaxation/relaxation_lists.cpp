// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/relaxation.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "packMesh/core/tolerances.h"

namespace packmesh {
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

bool Relaxation::beginsAnew() const {
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
