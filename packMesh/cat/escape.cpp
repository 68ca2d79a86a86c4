// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/escape.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "packMesh/cat/block_escape.h"
#include "packMesh/core/timer.h"

namespace packmesh {
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
