// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/shared_bodies.h"

#include <algorithm>
#include <cstring>
#include <tuple>

namespace packmesh {
namespace {

/// The part of a body that a contact changes.
struct Change {
  Vec3 position;
  Quaternion::Coefficients orientation;
  double scale, moved, overlap;
  std::int64_t slot;
};

bool before(const Body& a, const Body& b) {
  return std::tie(a.block, a.id) < std::tie(b.block, b.id);
}

/// Sorts any bodies by block, then by id.
void sortAll(std::vector<Body>& bodies) {
  struct Key {
    std::int32_t block, index;
    std::int64_t id;
  };
  std::vector<Key> keys;
  keys.reserve(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i)
    keys.push_back({bodies[i].block, static_cast<std::int32_t>(i), bodies[i].id});
  std::sort(keys.begin(), keys.end(),
            [](const Key& a, const Key& b) { return std::tie(a.block, a.id) < std::tie(b.block, b.id); });
  std::vector<Body> sorted;
  sorted.reserve(bodies.size());
  for (const Key& key : keys) sorted.push_back(bodies[key.index]);
  bodies = std::move(sorted);
}

/// Takes bodies out so that those that remain are sorted: of two in the wrong order, the one that has moved
/// to a later block, or, if several precede the second, that one. @return those taken out
std::vector<Body> takeUnsorted(std::vector<Body>& bodies) {
  constexpr std::size_t mostBack = 8;
  std::vector<Body> taken;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    std::size_t back = kept;
    while (back > 0 && kept - back < mostBack && before(bodies[i], bodies[back - 1])) --back;
    if (back > 0 && before(bodies[i], bodies[back - 1])) {
      taken.push_back(bodies[i]);
      continue;
    }
    taken.insert(taken.end(), bodies.begin() + back, bodies.begin() + kept);
    if (back != i) bodies[back] = bodies[i];
    kept = back + 1;
  }
  bodies.resize(kept);
  return taken;
}

/// Bodies are mostly sorted if there are fewer steps down than one in this many.
constexpr std::size_t mostlySorted = 8;

/// Sorts by block, then by id. Bodies are large, and mostly sorted already.
void sortByBlock(std::vector<Body>& bodies) {
  std::size_t steps = 0;  // down
  for (std::size_t i = 1; i < bodies.size(); ++i) steps += before(bodies[i], bodies[i - 1]);
  if (steps == 0) return;
  if (steps > bodies.size() / mostlySorted) return sortAll(bodies);
  std::vector<Body> taken = takeUnsorted(bodies);
  sortAll(taken);
  std::size_t from = bodies.size(), to = from + taken.size();
  bodies.resize(to);
  while (!taken.empty()) {  // from the end, so that no other memory is needed
    const bool last = from == 0 || before(bodies[from - 1], taken.back());
    bodies[--to] = last ? taken.back() : bodies[--from];
    if (last) taken.pop_back();
  }
}

}  // namespace

SharedBodies::SharedBodies(const Communicator& communicator, const BlockGrid& blocks)
    : communicator_(communicator), blocks_(blocks), rank_(communicator.rank()) {}

void SharedBodies::balance(std::vector<std::int64_t> work) {
  if (communicator_.alone()) return;
  communicator_.sum(work);
  owners_ = BlockOwners(blocks_, work, communicator_.size());
  foreign_.clear();
  lastBlock_ = none;
}

const std::vector<SharedBodies::ForeignNeighbor>& SharedBodies::foreignTo(int block) {
  const auto [at, isNew] = foreign_.try_emplace(block);
  std::vector<ForeignNeighbor>& foreign = at->second;
  if (!isNew) return foreign;
  const int owner = owners_.of(block);
  for (const BlockGrid::Neighbor& neighbor : blocks_.neighbors(block))
    if (owners_.of(neighbor.block) != owner) foreign.push_back({owners_.of(neighbor.block), neighbor.step});
  std::stable_sort(foreign.begin(), foreign.end(),
                   [](const ForeignNeighbor& a, const ForeignNeighbor& b) { return a.rank < b.rank; });
  return foreign;
}

template <class Visit>
void SharedBodies::forEachHolder(const Body& body, double range, Visit&& visit) {
  const int owner = owners_.of(body.block);
  visit(owner);
  if (body.block != lastBlock_) lastForeign_ = &foreignTo(lastBlock_ = body.block);
  const std::vector<ForeignNeighbor>& foreign = *lastForeign_;
  if (foreign.empty()) return;
  const BlockGrid::FaceDistances distances = blocks_.faceDistances(body.position, body.block);
  int last = owner;
  for (const ForeignNeighbor& neighbor : foreign) {
    if (neighbor.rank == last) continue;
    if (BlockGrid::squaredDistance(distances, neighbor.step) >= range * range) continue;
    last = neighbor.rank;
    visit(last);
  }
}

void SharedBodies::distribute(std::vector<Body>& bodies, double range) {
  if (!communicator_.alone()) {
    std::vector<std::vector<BodyState>> to(communicator_.size());
    std::size_t staying = 0;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      bool stays = false;
      forEachHolder(bodies[i], range, [&](int rank) {
        if (rank == rank_)
          stays = true;
        else
          to[rank].push_back(bodies[i]);
      });
      if (!stays) continue;
      bodies[i].changed = false;
      if (staying != i) bodies[staying] = bodies[i];
      ++staying;
    }
    bodies.resize(staying);
    for (const std::vector<BodyState>& states : communicator_.exchange(to))
      for (const BodyState& state : states) bodies.emplace_back(state);
  }
  sortByBlock(bodies);
  if (!communicator_.alone()) plan(bodies, range);
}

void SharedBodies::plan(const std::vector<Body>& bodies, double range) {
  std::vector<std::vector<std::int32_t>> common(communicator_.size());
  shared_.clear();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto index = static_cast<std::int32_t>(i);
    bool isShared = false;
    forEachHolder(bodies[i], range, [&](int rank) {
      if (rank == rank_) return;
      common[rank].push_back(index);
      isShared = true;
    });
    if (isShared) shared_.push_back(index);
  }
  peers_.clear();
  common_.clear();
  for (int rank = 0; rank < communicator_.size(); ++rank) {
    std::vector<std::int32_t>& indices = common[rank];
    if (indices.empty()) continue;
    Communicator::Peer peer;
    peer.rank = rank;
    peer.received.resize(indices.size() * sizeof(Change));
    peers_.push_back(std::move(peer));
    common_.push_back(std::move(indices));
  }
}

void SharedBodies::beginGhostUpdate(std::vector<Body>& bodies, const std::vector<std::int32_t>& candidates) {
  if (peers_.empty()) return;
  communicator_.awaitSent();
  for (std::size_t p = 0; p < peers_.size(); ++p) {
    const std::vector<std::int32_t>& common = common_[p];
    peers_[p].send.clear();
    std::size_t slot = 0;
    for (const std::int32_t i : candidates) {
      while (slot < common.size() && common[slot] < i) ++slot;
      if (slot == common.size()) break;
      const Body& body = bodies[i];
      if (common[slot] != i || !body.changed) continue;
      const Change change{body.position, body.orientation.coeffs(),      body.scale, body.moved,
                          body.overlap,  static_cast<std::int64_t>(slot)};
      const auto* bytes = reinterpret_cast<const std::byte*>(&change);
      peers_[p].send.insert(peers_[p].send.end(), bytes, bytes + sizeof change);
    }
  }
  communicator_.beginSwap(peers_);
  for (const std::int32_t i : candidates) bodies[i].changed = false;
}

std::vector<int> SharedBodies::finishGhostUpdate(std::vector<Body>& bodies) {
  std::vector<int> blocks;
  if (peers_.empty()) return blocks;
  communicator_.endSwap(peers_);
  for (std::size_t p = 0; p < peers_.size(); ++p)
    for (std::size_t at = 0; at < peers_[p].length; at += sizeof(Change)) {
      Change change;
      std::memcpy(static_cast<void*>(&change), &peers_[p].received[at], sizeof change);
      Body& body = bodies[common_[p][change.slot]];
      body.setPose({change.scale, Quaternion(change.orientation), change.position});
      body.moved = change.moved;
      body.overlap = change.overlap;
      body.touched = true;
      if (blocks.empty() || blocks.back() != body.block) blocks.push_back(body.block);
    }
  return blocks;
}

}  // namespace packmesh
