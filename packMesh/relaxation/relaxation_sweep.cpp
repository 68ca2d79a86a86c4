// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/relaxation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "packMesh/core/tolerances.h"
#include "packMesh/parallel/threads.h"

namespace packmesh {
namespace {

/// The first sweeps use coarse samples only, as long as contacts are deeper than this on average [fraction of
/// the largest radius].
constexpr double coarseDepth = 0.015;

/// If the deepest contact of a sweep was less than this, the next one examines all pairs completely [µm].
constexpr double nearlyResolved = 3.0 * tolerance::relaxationTolerance;

/// Sweeps from here on are economical. Packings below about 0.59 are complete by then.
constexpr std::int64_t economicalFrom = 300;

/// The second cell of a pair is loaded into the cache this many pairs before it is needed: cells lie anywhere
/// in the memory of their own and the adjacent blocks.
constexpr std::size_t pairsAhead = 10;

/// Number of blocks that a thread looks after at a time when cells are visited that may have moved.
constexpr std::int64_t blocksPerPart = 8;

/// Threads share the pairs of every block if a colour has fewer blocks per thread than this.
constexpr std::size_t blocksPerThread = 2;

/// Blocks with few pairs are left to fewer threads.
constexpr std::size_t fewestPairsOfThread = 200;

/// Threads that were held up by other programs share a block again after at most so many others.
constexpr int longestPause = 1024;

void prefetch(const Body& body) {
  constexpr std::size_t cacheLine = 64;
  const char* begin = reinterpret_cast<const char*>(&body);
  for (std::size_t at = 0; at < sizeof(Body); at += cacheLine) __builtin_prefetch(begin + at);
}

}  // namespace

/// Calls visit(block) for the blocks of which a cell may have moved.
template <class Visit>
void Relaxation::forEachStirred(Visit&& visit) const {
  threads_.forEachPart(
      blocks_.count(),
      [&](std::int64_t begin, std::int64_t end, int) {
        for (std::int64_t block = begin; block < end; ++block)
          if (stirred_[block]) visit(block);
      },
      blocksPerPart);
}

void Relaxation::forgetOverlaps() {
  forEachStirred([&](std::int64_t block) {
    for (std::int64_t i = bodyStart_[block]; i < bodyStart_[block + 1]; ++i) bodies_[i].overlap = 0.0;
  });
  std::fill(stirred_.begin(), stirred_.end(), false);
}

double Relaxation::largestDisplacement() {
  forEachStirred([&](std::int64_t block) {
    double& square = displacements_[block] = 0.0;
    for (std::int64_t i = bodyStart_[block]; i < bodyStart_[block + 1]; ++i)
      square = std::max(square, (bodies_[i].position - listedAt_[i]).squaredNorm());
  });
  return std::sqrt(*std::max_element(displacements_.begin(), displacements_.end()));
}

/// Whether the next sweep is to examine all pairs completely, unless coarse samples suffice.
bool Relaxation::nearlyResolvedBefore() const {
  return state_.sweeps == 0 || state_.last.deepest < nearlyResolved;
}

/// Whether coarse samples suffice for the next sweep.
bool Relaxation::coarseWillDo() const {
  return state_.coarsely && (state_.sweeps == 0 || state_.last.meanDepth() > coarseDepth * largestRadius_);
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
  std::vector<int>& around = around_[block];
  if (around.empty()) around = blocks_.around(block);
  for (const int b : around) active_[b] = stirred_[b] = true;
}

SweepSums Relaxation::sweep(double omega, double slack) {
  const bool sleeping = isSleeping(slack);
  if (slack < state_.slack) listed_ = false;  // pairs that were apart may now touch
  if (rebuildsNext()) {
    refreshLists(sleeping);
    active_.assign(blocks_.count(), !sleeping);
  } else if (state_.sweeps - foreseenInSweep_ >= foreseenFor) {
    expectMotion();
  }
  activateDisturbed();
  forgetOverlaps();
  SweepSums sums;
  solver_.setPush(omega, slack);
  const bool coarsely = coarseWillDo();
  sums.thorough = nearlyResolvedBefore() && !coarsely;
  solver_.setThoroughly(sums.thorough);
  solver_.setEconomical(state_.sweeps >= economicalFrom);
  if (slack < state_.slack || coarsely != state_.coarsely) activateAll();
  state_.slack = slack;
  state_.coarsely = coarsely;
  solver_.setCoarsely(state_.coarsely);
  for (int colour = 0; colour < BlockGrid::colours; ++colour) {
    if (!blocks_.has(colour)) continue;
    listActive(colour);
    // Changes are sent as early as possible, so that no rank waits.
    resolve(colour, true, sums);
    shared_.beginGhostUpdate(bodies_, exposedTo_[colour]);
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
  const auto resolveWith = [&](int& block, int thread, auto&& resolve) {
    SweepSums found;
    resolve(block, found);
    if (found.contacts == 0) block = none;
    of[thread].add(found);
  };
  if (threadsForPairs() > 1)
    for (int& block : due_)
      resolveWith(block, 0, [&](int b, SweepSums& found) { resolveTogether(b, found); });
  else
    threads_.forEach(static_cast<std::int64_t>(due_.size()), [&](std::int64_t i, int thread) {
      resolveWith(due_[i], thread, [&](int b, SweepSums& found) { resolve(b, found); });
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

/// Number of threads that share the pairs of each block; 1 if there are enough blocks for every thread to
/// resolve some by itself.
int Relaxation::threadsForPairs() const {
  if (threads_.alone()) return 1;
  std::size_t most = 0;
  for (const std::vector<int>& blocks : blocksOfColour_) most = std::max(most, blocks.size());
  if (most >= blocksPerThread * static_cast<std::size_t>(threads_.count())) return 1;
  return threads_.atOnce();
}

/// The same, by several threads.
void Relaxation::resolveTogether(int block, SweepSums& sums) {
  std::vector<ContactPair>& pairs = list_[block];
  const int parts = std::min(threadsForPairs(), static_cast<int>(pairs.size() / fewestPairsOfThread));
  if (parts < 2 || pauseLeft_ > 0) {
    pauseLeft_ = std::max(0, pauseLeft_ - 1);
    return resolve(block, sums);
  }
  std::unique_ptr<PairOrder>& order = orders_[block];
  if (!order || order->parts() != parts)
    order = std::make_unique<PairOrder>(pairs, bodies_, bodyStart_[block], bodyStart_[block + 1], parts);
  order->restart();
  PerThread<SweepSums> of(threads_);
  const auto onPair = [&](int thread) {
    return [&, thread](std::int32_t pair, std::int32_t later) {
      prefetch(bodies_[pairs[later].first]);
      prefetch(bodies_[pairs[later].second]);
      solver_.resolve(pairs[pair], bodies_, of[thread]);
    };
  };
  const auto onBody = [&](int thread) {
    return [&, thread](std::int32_t body) { solver_.resolveSurroundings(bodies_[body], of[thread]); };
  };
  threads_.forEach(parts, [&](std::int64_t part, int thread) {
    order->run(static_cast<int>(part), onPair(thread), onBody(thread));
  });
  order->finish(onPair(0), onBody(0));
  of.forEach([&](const SweepSums& found) { sums.add(found); });
  pause_ = order->isHeldUp() ? std::clamp(2 * pause_, 1, longestPause) : pause_ / 2;
  if (order->isHeldUp()) pauseLeft_ = pause_;
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

}  // namespace packmesh
