// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/neighbor_list.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "packMesh/core/box.h"
#include "packMesh/parallel/threads.h"

namespace packmesh {
namespace {

std::vector<Sphere> spheresOf(const PairListerInput& input) {
  std::vector<Sphere> spheres;
  spheres.reserve(input.bodies.size());
  for (const Body& b : input.bodies) spheres.push_back({b.position, input.radii[b.shape] * b.scale});
  return spheres;
}

}  // namespace

/// The second cell of a pair as found in the search.
struct PairLister::Partner {
  std::int64_t id;
  std::int32_t index;
  ImageShift shift;

  bool operator<(const Partner& other) const { return id != other.id ? id < other.id : shift < other.shift; }
};

PairLister::PairLister(const PairListerInput& input)
    : input_(input), spheres_(spheresOf(input)), grid_(spheres_) {
  for (const Sphere& sphere : spheres_) largest_ = std::max(largest_, sphere.radius);
  ids_.reserve(input.bodies.size());
  for (const Body& body : input.bodies) ids_.push_back(body.id);
}

/// Appends the pairs in which a body has the smaller id, sorted. @param partners used as scratch memory
void PairLister::find(int i, std::vector<Partner>& partners, std::vector<ContactPair>& pairs) const {
  partners.clear();
  const double reach = spheres_[i].radius + largest_ + input_.margin;
  forEachImage(spheres_[i].center, reach, input_.bounds, input_.period, [&](const ImageShift& shift) {
    // The image of i at +shift is near j; hence j displaced by -shift is near i.
    const bool unshifted = shift == ImageShift{0, 0, 0};
    const ImageShift opposite{static_cast<std::int8_t>(-shift[0]), static_cast<std::int8_t>(-shift[1]),
                              static_cast<std::int8_t>(-shift[2])};
    const Vec3 image = spheres_[i].center + displacement(shift, input_.period);
    grid_.forEachNear({image, spheres_[i].radius}, input_.margin, [&](int j) {
      // Every unordered pair of images is found twice, once from either side: keep the side of the smaller
      // id.
      if (ids_[i] > ids_[j]) return;
      if (i == j && (unshifted || shift < opposite)) return;
      partners.push_back({ids_[j], j, opposite});
    });
  });
  std::sort(partners.begin(), partners.end());
  for (const Partner& partner : partners) {
    ContactPair& pair = pairs.emplace_back();
    pair.first = i;
    pair.second = partner.index;
    pair.shift = partner.shift;
  }
}

void PairLister::list(const std::vector<int>& blocks, const Threads& threads, PairList& list) const {
  struct Scratch {
    std::vector<Partner> partners;
    std::vector<ContactPair> pairs;
  };
  PerThread<Scratch> scratch(threads);
  threads.forEach(static_cast<std::int64_t>(blocks.size()), [&](std::int64_t b, int thread) {
    const int block = blocks[b];
    Scratch& own = scratch[thread];
    own.pairs.clear();
    for (std::int64_t i = input_.start[block]; i < input_.start[block + 1]; ++i)
      find(static_cast<int>(i), own.partners, own.pairs);
    list[block] = own.pairs;  // as large as needed, and no larger
  });
}

namespace {

/// Counters of different parts are in different cache lines, which processors fetch in pairs.
constexpr std::int32_t countersApart = 128 / sizeof(std::int32_t);

/// How often a thread looks whether a pair is done before it lets others have its core.
constexpr int looksBeforeYield = 2000;

/// The threads of a block have work for a millisecond or two; those that have a core each wait for some
/// microseconds.
constexpr std::chrono::microseconds longWait(300);

/// Bodies and their weights, which are divided into parts of equal weight.
class Division {
 public:
  Division(const std::vector<Body>& bodies, const std::vector<std::int64_t>& weights)
      : bodies_(bodies), weights_(weights), part_(bodies.size(), 0) {}

  /// Divides these bodies across the longest edge of the box around them, again and again.
  void divide(std::vector<std::int32_t> members, int first, int parts) {
    if (parts == 1 || members.size() < 2) {
      for (const std::int32_t body : members) part_[body] = first;
      return;
    }
    Box box;
    std::int64_t weight = 0;
    for (const std::int32_t body : members) {
      box.add(bodies_[body].position);
      weight += weights_[body];
    }
    int axis;
    box.size().maxCoeff(&axis);
    std::sort(members.begin(), members.end(), [&](std::int32_t a, std::int32_t b) {
      const double x = bodies_[a].position[axis], y = bodies_[b].position[axis];
      return x != y ? x < y : a < b;
    });
    const int lower = parts / 2;
    std::int64_t below = 0;
    auto cut = members.begin();
    while (cut != members.end() && below * parts < weight * lower) below += weights_[*cut++];
    divide({members.begin(), cut}, first, lower);
    divide({cut, members.end()}, first + lower, parts - lower);
  }

  const std::vector<int>& part() const { return part_; }

 private:
  const std::vector<Body>& bodies_;
  const std::vector<std::int64_t>& weights_;
  std::vector<int> part_;
};

}  // namespace

PairOrder::PairOrder(const std::vector<ContactPair>& pairs, const std::vector<Body>& bodies,
                     std::int64_t begin, std::int64_t end, int parts)
    : parts_(parts) {
  std::vector<std::int64_t> weights(bodies.size(), 0);
  std::vector<char> isNear(bodies.size(), false);
  for (std::int64_t i = begin; i < end; ++i) isNear[i] = true;
  for (const ContactPair& pair : pairs) {
    ++weights[pair.first];
    isNear[pair.first] = isNear[pair.second] = true;
  }
  std::vector<std::int32_t> members;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (isNear[i]) members.push_back(static_cast<std::int32_t>(i));
  Division division(bodies, weights);
  division.divide(members, 0, parts);
  const std::vector<int>& partOf = division.part();

  std::stable_sort(members.begin(), members.end(),
                   [&](std::int32_t a, std::int32_t b) { return partOf[a] < partOf[b]; });
  std::vector<std::int32_t> counter(bodies.size(), 0);
  int last = 0;
  for (const std::int32_t body : members) {
    if (partOf[body] != last) counters_ += countersApart;
    last = partOf[body];
    counter[body] = counters_++;
  }
  done_ = std::make_unique<std::atomic<std::int32_t>[]>(counters_);

  // Steps in the order of the number of pairs that have to precede them, one after the other.
  std::vector<std::int32_t> before(bodies.size(), 0), level(bodies.size(), 0), levelOf(pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const std::int32_t a = pairs[k].first, b = pairs[k].second;
    parts_[partOf[a]].steps.push_back(
        {static_cast<std::int32_t>(k), {counter[a], counter[b]}, {before[a], before[b]}});
    levelOf[k] = level[a] = level[b] = std::max(level[a], level[b]) + 1;
    ++before[a];
    if (a != b) ++before[b];
  }
  for (Part& part : parts_)
    std::stable_sort(part.steps.begin(), part.steps.end(),
                     [&](const Step& a, const Step& b) { return levelOf[a.pair] < levelOf[b.pair]; });
  for (std::int64_t i = begin; i < end; ++i)
    parts_[partOf[i]].bodies.push_back({static_cast<std::int32_t>(i), counter[i], before[i]});
}

void PairOrder::restart() {
  for (Part& part : parts_) part.step = part.body = 0;
  for (std::int32_t i = 0; i < counters_; ++i) done_[i].store(0, std::memory_order_relaxed);
  heldUp_.store(false, std::memory_order_relaxed);
}

bool PairOrder::awaitLonger(std::int32_t counter, std::int32_t value) {
  for (int look = 0; look < looksBeforeYield; ++look)
    if (isDone(counter, value)) return true;
  const auto begin = std::chrono::steady_clock::now();
  while (!isDone(counter, value)) {
    if (std::chrono::steady_clock::now() - begin > longWait) heldUp_.store(true, std::memory_order_relaxed);
    if (isHeldUp()) return false;
    std::this_thread::yield();
  }
  return true;
}

}  // namespace packmesh
