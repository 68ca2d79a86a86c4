// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/escape.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "packMesh/cat/growing_cells.h"
#include "packMesh/core/timer.h"

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

namespace {

/// Unit in which volumes are summed as integers [fraction of the lumen], so that the sum does not depend on
/// the order.
constexpr double unitsOfVolume = 0x1p60;

/// Work of a cell below full size in multiples of that of others, for load balancing.
constexpr std::int64_t workOfLacking = 16;

class Escape {
 public:
  Escape(const Physics& physics, const Execution& execution, const GrowthSettings& growth,
         const EscapeSettings& settings, const PlaneFunctionFactory& factory,
         const std::function<bool()>& stop, const std::function<void(const std::vector<Body>&)>& observe,
         std::vector<Body> own)
      : physics_(physics),
        execution_(execution),
        growth_(growth),
        settings_(settings),
        factory_(factory),
        stop_(stop),
        observe_(observe),
        reserve_(settings.reserve),
        nextId_(1 - execution.communicator.min(-largestId(own))),
        // A cell that its block changes stays this near to the block: so do those of other blocks of the
        // colour, which therefore need not be known.
        drift_(physics.largest(&Shape::reach)),
        cells_(physics, execution, std::move(own), range(), 0, range() + drift_),
        rooms_(physics, execution, growth, factory, settings.orientations) {
    reserve_.resize(physics.species.size(), 0);
  }

  std::vector<EscapePhase> operator()() {
    phase("start", [](EscapePhase&) {});
    phase("swapping", [this](EscapePhase& p) { inAllBlocks(p, [](BlockEscape& block) { block.swap(); }); });
    phase("enlargement",
          [this](EscapePhase& p) { inAllBlocks(p, [](BlockEscape& block) { block.enlarge(); }); });
    phase("replacement", [this](EscapePhase& p) {
      withReserve(p, [](BlockEscape& block, ReserveShare& share) { block.replace(share); });
    });
    phase("growth", [this](EscapePhase& p) { growAll(p); });
    phase("hole filling", [this](EscapePhase& p) {
      if (noReserve()) return;
      const Holes holes(physics_, execution_);
      withReserve(p, [&](BlockEscape& block, ReserveShare& share) { block.fillHoles(holes, share); });
    });
    return std::move(phases_);
  }

  std::vector<Body> cells() const { return cells_.own(); }

 private:
  static std::int64_t largestId(const std::vector<Body>& cells) {
    std::int64_t largest = -1;
    for (const Body& cell : cells) largest = std::max(largest, cell.id);
    return largest;
  }

  /// Distance from a block within which cells matter to it [µm].
  double range() const { return drift_ + 2.0 * physics_.largest(&Shape::reach) + physics_.clearance; }

  template <class Work>
  void phase(const char* name, Work&& work) {
    EscapePhase phase;
    phase.name = name;
    {
      const Timer watch(phase.seconds);
      if (!stopped()) work(phase);
    }
    const std::vector<Body> own = cells_.own();
    std::vector<std::int64_t> sums = {phase.tried, phase.changed, static_cast<std::int64_t>(own.size()), 0,
                                      0};
    for (const Body& cell : own) {
      const double share = physics_.shapeOf(cell).volume() / physics_.container->volume();
      sums[3] += cell.scale == 1.0;
      sums[4] += std::llround(cell.scale * cell.scale * cell.scale * share * unitsOfVolume);
    }
    execution_.communicator.sum(sums);
    phase.tried = sums[0];
    phase.changed = sums[1];
    phase.cells = sums[2];
    phase.full = sums[3];
    phase.coverage = static_cast<double>(sums[4]) / unitsOfVolume;
    phases_.push_back(phase);
    if (observe_) observe_(own);
  }

  bool stopped() { return execution_.communicator.any(left_) || (stop_ && stop_()); }
  bool stoppedHere() {
    left_ = left_ || (execution_.interrupted && execution_.interrupted());
    return left_;
  }

  bool noReserve() const {
    return std::all_of(reserve_.begin(), reserve_.end(), [](std::int64_t bodies) { return bodies <= 0; });
  }

  void balance() {
    for (std::size_t i = 0; i < cells_.all().size(); ++i)
      if (cells_.isOwn(static_cast<std::int64_t>(i)))
        cells_.addWork(static_cast<std::int64_t>(i), cells_.all()[i].scale < 1.0 ? workOfLacking : 1);
    cells_.distribute();
  }

  /// Calls work(number, block) for this rank's blocks for which chosen(number).
  template <class Chosen, class Work>
  void inBlocks(EscapePhase& phase, Chosen&& chosen, Work&& work) {
    const Communicator& ranks = execution_.communicator;
    for (int colour = 0; colour < BlockGrid::colours; ++colour) {
      if (!cells_.grid().has(colour)) continue;
      if (stopped()) return;
      std::int64_t tried = 0;
      Rooms::Counters most = counters_;
      std::vector<Body> added;
      for (const GrowingCells::Block& block : cells_.blocksOf(colour)) {
        if (!chosen(block.number)) continue;
        Rooms::Trials trials{permittedIn(block.number), [this] { return stoppedHere(); }, counters_};
        BlockEscape escape(physics_, settings_, rooms_, trials, cells_.grid().boxOf(block.number),
                           cellsOf(block),
                           nextId_ + static_cast<std::int64_t>(block.number) * settings_.holes);
        work(block.number, escape);
        tried += escape.tried();
        phase.changed += escape.changed();
        most.trials = std::max(most.trials, trials.counters.trials);
        most.iterations = std::max(most.iterations, trials.counters.iterations);
        takeBack(block, escape.cells(), added);
      }
      phase.tried += tried;
      counters_ = {-ranks.min(-most.trials), -ranks.min(-most.iterations)};
      if (ranks.any(tried > 0)) exchange(std::move(added));
    }
  }

  /// The same for all blocks.
  template <class Work>
  void inAllBlocks(EscapePhase& phase, Work&& work) {
    balance();
    inBlocks(
        phase, [](int) { return true; }, [&](int, BlockEscape& block) { work(block); });
  }

  LocalGrowth::Permitted permittedIn(int block) const {
    if (cells_.grid().count() == 1) return {};
    return [this, block](const Vec3& p) { return cells_.grid().squaredDistance(p, block) < drift_ * drift_; };
  }

  /// Of a block and, frozen, those around it.
  std::vector<Body> cellsOf(const GrowingCells::Block& block) const {
    std::vector<Body> cells;
    for (const std::int64_t i : block.cells) cells.push_back(cells_.all()[i]);
    for (const std::int64_t i : block.around) {
      cells.push_back(cells_.all()[i]);
      cells.back().frozen = true;
    }
    return cells;
  }

  void takeBack(const GrowingCells::Block& block, const std::vector<Body>& cells, std::vector<Body>& added) {
    for (std::size_t k = 0; k < block.cells.size(); ++k) cells_.all()[block.cells[k]] = cells[k];
    added.insert(added.end(),
                 cells.begin() + static_cast<std::ptrdiff_t>(block.cells.size() + block.around.size()),
                 cells.end());
  }

  /// Numbers the new cells, in the order of the blocks, and tells other ranks what has changed.
  void exchange(std::vector<Body> added) {
    const auto own = static_cast<std::int64_t>(added.size());
    const std::int64_t first = nextId_ + execution_.communicator.sumBefore({own})[0];
    for (std::size_t k = 0; k < added.size(); ++k) added[k].id = first + static_cast<std::int64_t>(k);
    nextId_ += execution_.communicator.sum(own);
    cells_.add(added);
    cells_.distribute();
  }

  /// Of `parts` blocks, the one at this place: shares differ by one at most, evenly spread, and the last one
  /// is not empty.
  ReserveShare shareAt(std::int64_t place, std::int64_t parts) const {
    ReserveShare share;
    for (const std::int64_t bodies : reserve_) {
      const auto upTo = [&](std::int64_t n) { return n * (bodies / parts) + n * (bodies % parts) / parts; };
      share.bodies.push_back(upTo(place + 1) - upTo(place));
      share.elsewhere.push_back(bodies - share.bodies.back());
    }
    return share;
  }

  /// Calls work(block, share) with shares of the reserve for blocks that have not had enough, until all have
  /// or nothing is left. The last of the blocks always has a share of every species, so each round either
  /// uses some of it or leaves fewer blocks.
  template <class Work>
  void withReserve(EscapePhase& phase, Work&& work) {
    balance();
    std::vector<int> waiting = cells_.ownBlocks();
    while (!noReserve() && !stopped()) {
      const auto own = static_cast<std::int64_t>(waiting.size());
      const std::int64_t all = execution_.communicator.sum(own);
      if (all == 0) return;
      const std::int64_t first = execution_.communicator.sumBefore({own})[0];
      std::map<int, ReserveShare> shares;
      for (std::size_t k = 0; k < waiting.size(); ++k) {
        ReserveShare share = shareAt(first + static_cast<std::int64_t>(k), all);
        const bool empty = std::all_of(share.bodies.begin(), share.bodies.end(),
                                       [](std::int64_t bodies) { return bodies == 0; });
        if (!empty) shares.emplace(waiting[k], std::move(share));
      }
      std::vector<std::int64_t> used(reserve_.size(), 0);
      inBlocks(
          phase, [&](int block) { return shares.count(block) > 0; },
          [&](int number, BlockEscape& block) {
            ReserveShare& share = shares.at(number);
            for (std::size_t s = 0; s < used.size(); ++s) used[s] += share.bodies[s];
            work(block, share);
            for (std::size_t s = 0; s < used.size(); ++s) used[s] -= share.bodies[s];
            if (!block.missed()) waiting.erase(std::find(waiting.begin(), waiting.end(), number));
          });
      execution_.communicator.sum(used);
      for (std::size_t s = 0; s < used.size(); ++s) reserve_[s] -= used[s];
    }
  }

  void growAll(EscapePhase& phase) {
    std::vector<Body> own = cells_.own();
    std::vector<IdScale> before;
    for (const Body& cell : own)
      if (cell.scale < 1.0) before.push_back({cell.id, cell.scale});
    if (!execution_.communicator.any(!before.empty())) return;
    phase.tried = static_cast<std::int64_t>(before.size());
    GrowthSettings last = growth_;
    last.barriers = {growth_.barriers.back()};
    last.initialScale = 0.0;
    last.giveUpAfter = 1;
    GrowthCallbacks callbacks;
    callbacks.stop = stop_;
    GrowthStatistics statistics;
    grow(physics_, execution_, last, *factory_(), callbacks, own, statistics);
    std::vector<IdScale> after;
    for (const Body& cell : own) after.push_back({cell.id, cell.scale});
    phase.changed = larger(before, after);
    cells_.replace(std::move(own));
  }

  struct IdScale {
    std::int64_t id;
    double scale;
  };

  /// Number of cells whose scale was less before, as far as this rank counts: those of certain ids, since
  /// cells can have changed ranks.
  std::int64_t larger(const std::vector<IdScale>& before, const std::vector<IdScale>& after) const {
    const auto countedHere = [&](const std::vector<IdScale>& own) {
      const int ranks = execution_.communicator.size();
      std::vector<std::vector<IdScale>> to(ranks);
      for (const IdScale& cell : own) to[cell.id % ranks].push_back(cell);
      std::map<std::int64_t, double> scales;
      for (const std::vector<IdScale>& some : execution_.communicator.exchange(to))
        for (const IdScale& cell : some) scales.emplace(cell.id, cell.scale);
      return scales;
    };
    const std::map<std::int64_t, double> first = countedHere(before), last = countedHere(after);
    return std::count_if(first.begin(), first.end(),
                         [&](const auto& cell) { return last.at(cell.first) > cell.second; });
  }

  const Physics& physics_;
  const Execution& execution_;
  const GrowthSettings& growth_;
  const EscapeSettings& settings_;
  const PlaneFunctionFactory& factory_;
  const std::function<bool()>& stop_;
  const std::function<void(const std::vector<Body>&)>& observe_;
  std::vector<std::int64_t> reserve_;  ///< bodies left, per species
  std::int64_t nextId_;
  double drift_;  ///< [µm]
  GrowingCells cells_;
  Rooms rooms_;
  Rooms::Counters counters_;  ///< the largest of any block so far, so that no block repeats random numbers
  bool left_ = false;         ///< this rank has abandoned work
  std::vector<EscapePhase> phases_;
};

}  // namespace

std::vector<EscapePhase> escape(const Physics& physics, const Execution& execution,
                                const GrowthSettings& growth, const EscapeSettings& settings,
                                const PlaneFunctionFactory& factory, const std::function<bool()>& stop,
                                const std::function<void(const std::vector<Body>&)>& observe,
                                std::vector<Body>& own) {
  Escape escape(physics, execution, growth, settings, factory, stop, observe, std::move(own));
  std::vector<EscapePhase> phases = escape();
  own = escape.cells();
  return phases;
}

}  // namespace packmesh
