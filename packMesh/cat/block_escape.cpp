// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/block_escape.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include "packMesh/cat/growing_cells.h"

namespace packmesh {

std::vector<int> bestAssignment(const std::vector<std::vector<double>>& scores) {
  // Costs are negative scores. The potentials keep every reduced cost cost(r,c) - u[r] - v[c] >= 0; rows are
  // added one at a time along the shortest alternating path. Column n is the start of a path.
  const std::size_t n = scores.size(), none = n;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::vector<double> u(n, 0.0), v(n + 1, 0.0);
  std::vector<std::size_t> rowOf(n + 1, none);
  for (std::size_t row = 0; row < n; ++row) {
    std::vector<double> distance(n, infinity);
    std::vector<std::size_t> before(n, n);
    std::vector<char> done(n + 1, 0);
    std::size_t column = n;
    rowOf[n] = row;
    do {
      done[column] = 1;
      const std::size_t r = rowOf[column];
      std::size_t next = n;
      for (std::size_t c = 0; c < n; ++c) {
        if (done[c]) continue;
        const double reduced = -scores[r][c] - u[r] - v[c];
        if (reduced < distance[c]) {
          distance[c] = reduced;
          before[c] = column;
        }
        if (next == n || distance[c] < distance[next]) next = c;
      }
      const double shortest = distance[next];
      for (std::size_t c = 0; c <= n; ++c) {
        if (done[c]) {
          u[rowOf[c]] += shortest;
          v[c] -= shortest;
        } else {
          distance[c] -= shortest;
        }
      }
      column = next;
    } while (rowOf[column] != none);
    while (column != n) {
      rowOf[column] = rowOf[before[column]];
      column = before[column];
    }
  }
  std::vector<int> columnOf(n);
  for (std::size_t c = 0; c < n; ++c) columnOf[rowOf[c]] = static_cast<int>(c);
  return columnOf;
}

namespace {

/// Gains below this fraction of a cell's volume count as zero.
constexpr double leastGain = 1e-6;

/// A body is tried in a hole if the hole's sphere has at least this fraction of its volume.
constexpr double holeFraction = 0.05;

}  // namespace

BlockEscape::BlockEscape(const Physics& physics, const EscapeSettings& settings, Rooms& rooms,
                         Rooms::Trials& trials, const Box& region, std::vector<Body> cells,
                         std::int64_t firstId)
    : physics_(physics),
      settings_(settings),
      rooms_(rooms),
      trials_(trials),
      region_(region),
      state_(std::move(cells)),
      nextId_(firstId) {}

double BlockEscape::volume(int shape, double scale) const {
  return scale * scale * scale * physics_.shapes[shape]->volume();
}

/// Cells below full size, in descending order of missing volume.
std::vector<std::int64_t> BlockEscape::lacking() const {
  std::vector<std::pair<double, std::int64_t>> order;
  for (std::size_t i = 0; i < state_.size(); ++i)
    if (state_[i].scale < 1.0 && !isFixed(physics_, state_[i]))
      order.emplace_back(volumeOf(static_cast<std::int64_t>(i)) - volume(state_[i].shape, 1.0),
                         static_cast<std::int64_t>(i));
  std::sort(order.begin(), order.end());
  std::vector<std::int64_t> cells;
  for (const auto& entry : order) cells.push_back(entry.second);
  return cells;
}

/// A group of cells no two of which are neighbours: some below full size, and others to swap with.
std::vector<std::int64_t> BlockEscape::group(const std::vector<std::int64_t>& wanted) const {
  std::vector<std::int64_t> order = wanted, members;
  for (std::size_t i = 0; i < state_.size(); ++i)
    if (state_[i].scale == 1.0 && !isFixed(physics_, state_[i]))
      order.push_back(static_cast<std::int64_t>(i));
  for (const std::int64_t cell : order) {
    if (static_cast<int>(members.size()) == settings_.groupSize) break;
    // At most half of them are below full size: full-size cells may have more room than they need.
    if (state_[cell].scale < 1.0 && static_cast<int>(members.size()) >= settings_.groupSize / 2) continue;
    const bool apart = std::none_of(members.begin(), members.end(), [&](std::int64_t other) {
      return other == cell || rooms_.neighbours(state_[cell], state_[other]);
    });
    if (apart) members.push_back(cell);
  }
  return members;
}

void BlockEscape::swap() {
  std::vector<std::int64_t> wanted = lacking();
  for (int round = 0; round < settings_.swapRounds && !wanted.empty() && !stopped(); ++round) {
    const std::vector<std::int64_t> members = group(wanted);
    for (const std::int64_t cell : members)
      wanted.erase(std::remove(wanted.begin(), wanted.end(), cell), wanted.end());
    swapWithin(members);
  }
}

void BlockEscape::swapWithin(const std::vector<std::int64_t>& members) {
  const std::size_t n = members.size();
  std::vector<BodyKind> kinds;      // bodies of one kind differ only in position
  std::vector<std::size_t> number;  // of the kind of each member
  for (const std::int64_t cell : members) {
    number.push_back(std::find(kinds.begin(), kinds.end(), kindOf(state_[cell])) - kinds.begin());
    if (number.back() == kinds.size()) kinds.push_back(kindOf(state_[cell]));
  }
  std::vector<std::vector<std::optional<Pose>>> reached(n);  // by room and kind
  std::vector<std::vector<double>> score(n, std::vector<double>(n, 0.0));
  for (std::size_t room = 0; room < n; ++room)
    for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
      if (kind == number[room]) {
        reached[room].emplace_back(state_[members[room]].pose());
      } else {
        ++tried_;
        reached[room].push_back(rooms_.largest(state_, members[room], kinds[kind], trials_));
      }
    }
  double before = 0.0, after = 0.0;
  for (std::size_t body = 0; body < n; ++body)
    for (std::size_t room = 0; room < n; ++room) {
      const auto& pose = reached[room][number[body]];
      score[body][room] =
          pose ? volume(kinds[number[body]].shape, pose->scale) : -physics_.container->volume();
    }
  const std::vector<int> roomOf = bestAssignment(score);
  for (std::size_t body = 0; body < n; ++body) {
    before += score[body][body];
    after += score[body][roomOf[body]];
  }
  if (after <= (1.0 + leastGain) * before) return;
  std::vector<Body> swapped = state_;
  std::int64_t changed = 0;
  for (std::size_t body = 0; body < n; ++body) {
    Body& place = swapped[members[roomOf[body]]];
    changed += number[body] != number[roomOf[body]];
    place.species = kinds[number[body]].species;
    place.shape = kinds[number[body]].shape;
    place.setPose(*reached[roomOf[body]][number[body]]);
  }
  std::vector<std::int64_t> sorted = members;
  std::sort(sorted.begin(), sorted.end());
  if (!rooms_.valid(sorted, swapped)) return;
  state_ = std::move(swapped);
  changed_ += changed;
}

/// Tries another body in the room of a cell, or the same one rotated, and keeps it if that gains volume.
bool BlockEscape::take(std::int64_t cell, const BodyKind& kind) {
  const std::optional<Pose> pose = rooms_.largest(state_, cell, kind, trials_);
  if (!pose || volume(kind.shape, pose->scale) <= (1.0 + leastGain) * volumeOf(cell)) return false;
  state_[cell].species = kind.species;
  state_[cell].shape = kind.shape;
  state_[cell].setPose(*pose);
  return true;
}

void BlockEscape::enlarge() {
  for (const std::int64_t cell : lacking()) {
    if (stopped()) return;
    ++tried_;
    const double before = volumeOf(cell);
    rooms_.enlarge(state_, cell, trials_);
    if (state_[cell].scale < 1.0) take(cell, kindOf(state_[cell]));
    changed_ += volumeOf(cell) > before;
  }
}

/// Species in the reserve, in descending order of size.
std::vector<int> BlockEscape::bySize(const ReserveShare& share) const {
  std::vector<int> species;
  for (std::size_t s = 0; s < share.bodies.size(); ++s)
    if (share.bodies[s] > 0 || share.elsewhere[s] > 0) species.push_back(static_cast<int>(s));
  std::stable_sort(species.begin(), species.end(),
                   [&](int a, int b) { return volume(kind(a).shape, 1.0) > volume(kind(b).shape, 1.0); });
  return species;
}

/// Whether this block may use a body of the species.
bool BlockEscape::offered(int species, const ReserveShare& share) {
  missed_ = missed_ || share.bodies[species] == 0;
  return share.bodies[species] > 0;
}

void BlockEscape::replace(ReserveShare& share) {
  for (const std::int64_t cell : lacking()) {
    if (stopped()) return;
    if (physics_.isDeformed(state_[cell])) continue;  // the reserve has no such bodies
    ++tried_;
    const int first = state_[cell].species;
    for (const int species : bySize(share))
      if (species != state_[cell].species && volume(kind(species).shape, 1.0) > volumeOf(cell) &&
          offered(species, share))
        take(cell, kind(species));
    if (state_[cell].species == first) continue;
    ++changed_;
    ++share.bodies[first];
    --share.bodies[state_[cell].species];
  }
}

/// Whether only other blocks have bodies left.
bool BlockEscape::usedUp(const ReserveShare& share) {
  const auto any = [](const std::vector<std::int64_t>& bodies) {
    return std::any_of(bodies.begin(), bodies.end(), [](std::int64_t number) { return number > 0; });
  };
  const bool usedUp = !any(share.bodies) && any(share.elsewhere);
  missed_ = missed_ || usedUp;
  return usedUp;
}

void BlockEscape::fillHoles(const Holes& holes, ReserveShare& share) {
  const std::vector<int> smallestLast = bySize(share);
  if (smallestLast.empty()) return;
  const double least = std::cbrt(0.75 / M_PI * holeFraction * volume(kind(smallestLast.back()).shape, 1.0));
  for (const Sphere& hole : holes.in(region_, state_, least)) {
    if (tried_ == settings_.holes || stopped()) return;
    if (usedUp(share)) return;
    ++tried_;
    const double room = 4.0 / 3.0 * M_PI * hole.radius * hole.radius * hole.radius;
    for (const int s : bySize(share)) {
      if (room < holeFraction * volume(kind(s).shape, 1.0) || !offered(s, share)) continue;
      const auto cell = static_cast<std::int64_t>(state_.size());
      state_.push_back(makeBody(nextId_, s, kind(s).shape, Pose{1.0, Quaternion::Identity(), hole.center}));
      const std::optional<Pose> pose = rooms_.largest(state_, cell, kind(s), trials_);
      if (pose && pose->scale == 1.0) {
        state_[cell].setPose(*pose);
        ++nextId_;
        --share.bodies[s];
        ++changed_;
        break;
      }
      state_.pop_back();
    }
  }
}

}  // namespace packmesh
