// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Neighbour lists: the cells that may touch, found, and sorted by the blocks and threads that process
/// them.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/mesh/neighbor_search.h"
#include "packMesh/parallel/blocks.h"
#include "packMesh/parallel/threads.h"
#include "packMesh/relaxation/body.h"
#include "packMesh/relaxation/contact_kernels.h"

namespace packmesh {

/// Two cells near each other: `second` displaced by `shift` periods is near `first`. A cell can be paired
/// with its own image.
struct ContactPair {
  std::int32_t first, second;  ///< indices into the bodies, first.id <= second.id
  ImageShift shift;
  bool deep = true;             ///< penetrated deeply at the last test: coarse samples suffice
  bool coarse = false;          ///< `touched` are clusters of the coarse samples
  std::uint8_t quickLooks = 0;  ///< since the last complete test of the pair
  float extraClearance = 0.0f;  ///< in addition to the problem's clearance [µm]
  /// The test of the pair is skipped until `moved`, the sum over both cells, reaches this [µm].
  float apartUntil = -1.0f;
  /// Until `moved` reaches this, only the clusters in the masks can touch the other cell [µm].
  float masksUntil = -1.0f;
  ClusterMask masks[2] = {allClusters, allClusters};
  /// The clusters that touched at the last complete test of the pair.
  ClusterMask touched[2] = {0, 0};
};

/// The pairs of each block, sorted by ids and shift.
using PairList = std::vector<std::vector<ContactPair>>;

/// Bodies among which pairs are searched. References only.
struct PairListerInput {
  const std::vector<Body>& bodies;         ///< wrapped into the bounds; sorted by block, then by id
  const std::vector<std::int64_t>& start;  ///< first body of each block; one past the last at the end
  const std::vector<double>& radii;        ///< per shape, of cells of scale 1 [µm]
  double margin = 0.0;                     ///< [µm]
  Box bounds;
  Vec3 period = Vec3::Zero();
};

/// Finds all pairs of bodies whose bounding spheres come nearer than the margin, each unordered pair of
/// images once, assigned to the block of the cell with the smaller id. Positions are those at construction.
class PairLister {
 public:
  explicit PairLister(const PairListerInput& input);

  /// Lists the pairs of blocks. @param list one entry per block; those of `blocks` are replaced
  void list(const std::vector<int>& blocks, const Threads& threads, PairList& list) const;

 private:
  struct Partner;
  void find(int body, std::vector<Partner>& partners, std::vector<ContactPair>& pairs) const;

  const PairListerInput input_;
  const std::vector<Sphere> spheres_;
  const SphereGrid grid_;
  std::vector<std::int64_t> ids_;
  double largest_ = 0.0;  ///< radius [µm]
};

/// Two pairs without a common body can be resolved at the same time. Each pair therefore waits only for those
/// of its two bodies that precede it in the list: every body counts the pairs that are done with it. The
/// result is that of the list from beginning to end, for any number of threads.
///
/// The space of the block is divided into parts with as many pairs each, one for a thread, so that most
/// bodies are moved by one thread. A thread that does not get its core holds up the others: then one does the
/// rest.
class PairOrder {
 public:
  /// @param pairs of the block, in order
  /// @param begin,end the bodies of the block
  /// @param parts at least 1
  PairOrder(const std::vector<ContactPair>& pairs, const std::vector<Body>& bodies, std::int64_t begin,
            std::int64_t end, int parts);

  int parts() const { return static_cast<int>(parts_.size()); }

  /// Before every time that the pairs are resolved.
  void restart();

  /// Calls onPair(index, later index) for the pairs of one part, each after those it waits for, and
  /// onBody(index) for those of the block's bodies that are in the part, after all their pairs. Neither may
  /// throw. Ends early if the threads are held up.
  /// Pre: after restart(), every part is run by a thread of its own, all at the same time
  template <class OnPair, class OnBody>
  void run(int part, OnPair&& onPair, OnBody&& onBody) {
    advance(
        parts_[part], [&](std::int32_t counter, std::int32_t value) { return await(counter, value); }, onPair,
        onBody);
  }

  /// Whether a thread has waited for another so long, since restart(), that other programs must have occupied
  /// its core: then one thread alone is faster.
  bool isHeldUp() const { return heldUp_.load(std::memory_order_relaxed); }

  /// Does what is left after run() for all parts. For one thread.
  template <class OnPair, class OnBody>
  void finish(OnPair&& onPair, OnBody&& onBody) {
    bool isLeft = true;
    while (isLeft) {
      isLeft = false;
      for (Part& part : parts_)
        isLeft |= !advance(
            part, [&](std::int32_t counter, std::int32_t value) { return isDone(counter, value); }, onPair,
            onBody);
    }
  }

 private:
  /// A pair, and for its bodies the counters of pairs done and what they are before it.
  struct Step {
    std::int32_t pair;
    std::array<std::int32_t, 2> counter, before;
  };
  struct OwnBody {
    std::int32_t body, counter, pairs;
  };
  struct Part {
    std::vector<Step> steps;
    std::vector<OwnBody> bodies;
    std::size_t step = 0, body = 0;  ///< the next ones
  };
  /// The data of a pair is loaded into the cache this many steps before it is needed.
  static constexpr std::size_t stepsAhead = 6;

  /// Continues with a part as long as isReady(counter, value) says that a counter has reached its value.
  /// @return whether the part is complete
  template <class IsReady, class OnPair, class OnBody>
  bool advance(Part& part, IsReady&& isReady, OnPair&& onPair, OnBody&& onBody) {
    const std::vector<Step>& steps = part.steps;
    std::size_t k = part.step;  // written once: other threads write next to it
    for (; k < steps.size(); ++k) {
      const Step& step = steps[k];
      if (!isReady(step.counter[0], step.before[0]) || !isReady(step.counter[1], step.before[1])) break;
      onPair(step.pair, steps[std::min(k + stepsAhead, steps.size() - 1)].pair);
      done_[step.counter[0]].store(step.before[0] + 1, std::memory_order_release);
      done_[step.counter[1]].store(step.before[1] + 1, std::memory_order_release);
    }
    part.step = k;
    if (k < steps.size()) return false;
    for (; part.body < part.bodies.size(); ++part.body) {
      const OwnBody& own = part.bodies[part.body];
      if (!isReady(own.counter, own.pairs)) return false;
      onBody(own.body);
    }
    return true;
  }

  bool isDone(std::int32_t counter, std::int32_t value) const {
    return done_[counter].load(std::memory_order_acquire) == value;
  }
  /// False if the threads are held up.
  bool await(std::int32_t counter, std::int32_t value) {
    return isDone(counter, value) || awaitLonger(counter, value);
  }
  bool awaitLonger(std::int32_t counter, std::int32_t value);

  std::vector<Part> parts_;
  std::int32_t counters_ = 0;
  std::unique_ptr<std::atomic<std::int32_t>[]> done_;  ///< for every body, those of a part side by side
  std::atomic<bool> heldUp_{false};
};

}  // namespace packmesh
