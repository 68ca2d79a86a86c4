// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/escape/escape.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "packMesh/core/timer.h"
#include "packMesh/escape/assignment.h"
#include "packMesh/escape/holes.h"

namespace packmesh {
namespace {

/// Gains below this fraction of a cell's volume count as zero.
constexpr double leastGain = 1e-6;

/// A body is tried in a hole if the hole's sphere has at least this fraction of its volume.
constexpr double holeFraction = 0.05;

class Escape {
 public:
  Escape(const GrowthScene& scene, const GrowthSettings& growth, const EscapeSettings& settings,
         const PlaneFunctionFactory& factory, const std::function<bool()>& stop,
         const std::function<void(const std::vector<Body>&)>& observe, std::vector<Body>& state)
      : scene_(scene),
        growth_(growth),
        settings_(settings),
        stop_(stop),
        observe_(observe),
        reserve_(settings.reserve),
        state_(state),
        planeFunction_(factory(scene)),
        rooms_(scene, growth, factory, settings.orientations) {
    reserve_.resize(scene.shapes.size(), 0);
  }

  std::vector<EscapePhase> operator()() {
    phase("start", [](EscapePhase&) {});
    phase("swapping", [this](EscapePhase& p) { swap(p); });
    phase("enlargement", [this](EscapePhase& p) { enlarge(p); });
    phase("replacement", [this](EscapePhase& p) { replace(p); });
    phase("growth", [this](EscapePhase& p) { growAll(p); });
    phase("hole filling", [this](EscapePhase& p) { fillHoles(p); });
    return std::move(phases_);
  }

 private:
  template <class Work>
  void phase(const char* name, Work&& work) {
    EscapePhase phase;
    phase.name = name;
    {
      const Timer watch(phase.seconds);
      if (!stopped()) work(phase);
    }
    for (const Body& cell : state_) {
      phase.coverage += volume(cell.species, cell.scale) / scene_.container->volume();
      phase.full += cell.scale == 1.0;
    }
    phase.cells = static_cast<std::int64_t>(state_.size());
    phases_.push_back(phase);
    if (observe_) observe_(state_);
  }

  bool stopped() const { return stop_ && stop_(); }

  double volume(int species, double scale) const {
    return scale * scale * scale * scene_.shapes[species]->volume();
  }
  double volumeOf(std::int64_t cell) const { return volume(state_[cell].species, state_[cell].scale); }

  /// Cells below full size, in descending order of missing volume.
  std::vector<std::int64_t> lacking() const {
    std::vector<std::pair<double, std::int64_t>> order;
    for (std::size_t i = 0; i < state_.size(); ++i)
      if (state_[i].scale < 1.0)
        order.emplace_back(volumeOf(static_cast<std::int64_t>(i)) - volume(state_[i].species, 1.0),
                           static_cast<std::int64_t>(i));
    std::sort(order.begin(), order.end());
    std::vector<std::int64_t> cells;
    for (const auto& entry : order) cells.push_back(entry.second);
    return cells;
  }

  /// A group of cells no two of which are neighbours: some below full size, and others to swap with.
  std::vector<std::int64_t> group(const std::vector<std::int64_t>& wanted) const {
    std::vector<std::int64_t> order = wanted, members;
    for (std::size_t i = 0; i < state_.size(); ++i)
      if (state_[i].scale == 1.0 && !scene_.isFixed(state_[i])) order.push_back(static_cast<std::int64_t>(i));
    for (const std::int64_t cell : order) {
      if (static_cast<int>(members.size()) == settings_.groupSize) break;
      // At most half of them are below full size: full-size cells may have more room than they need.
      if (state_[cell].scale < 1.0 && static_cast<int>(members.size()) >= settings_.groupSize / 2) continue;
      const bool apart = std::none_of(members.begin(), members.end(), [&](std::int64_t other) {
        return other == cell || rooms_.neighbours(state_, cell, other);
      });
      if (apart) members.push_back(cell);
    }
    return members;
  }

  void swap(EscapePhase& phase) {
    std::vector<std::int64_t> wanted = lacking();
    for (int round = 0; round < settings_.swapRounds && !wanted.empty() && !stopped(); ++round) {
      const std::vector<std::int64_t> members = group(wanted);
      for (const std::int64_t cell : members)
        wanted.erase(std::remove(wanted.begin(), wanted.end(), cell), wanted.end());
      swapWithin(members, phase);
    }
  }

  void swapWithin(const std::vector<std::int64_t>& members, EscapePhase& phase) {
    const std::size_t n = members.size();
    // By room and species: bodies of one species differ only in position.
    std::vector<std::vector<std::optional<Pose>>> reached(n);
    std::vector<std::vector<double>> score(n, std::vector<double>(n, 0.0));
    for (std::size_t room = 0; room < n; ++room) {
      reached[room].resize(scene_.shapes.size());
      std::vector<char> tried(scene_.shapes.size(), 0);
      for (const std::int64_t cell : members) {
        const int species = state_[cell].species;
        if (std::exchange(tried[species], 1)) continue;
        if (species == state_[members[room]].species) {
          reached[room][species] = state_[members[room]].pose();
        } else {
          ++phase.tried;
          reached[room][species] = rooms_.largest(state_, members[room], species, stop_);
        }
      }
    }
    double before = 0.0, after = 0.0;
    for (std::size_t body = 0; body < n; ++body)
      for (std::size_t room = 0; room < n; ++room) {
        const int species = state_[members[body]].species;
        const auto& pose = reached[room][species];
        score[body][room] = pose ? volume(species, pose->scale) : -scene_.container->volume();
      }
    const std::vector<int> roomOf = bestAssignment(score);
    for (std::size_t body = 0; body < n; ++body) {
      before += score[body][body];
      after += score[body][roomOf[body]];
    }
    if (after <= (1.0 + leastGain) * before) return;
    std::vector<Body> swapped = state_;
    for (std::size_t body = 0; body < n; ++body) {
      const int species = state_[members[body]].species;
      Body& place = swapped[members[roomOf[body]]];
      phase.changed += place.species != species;
      place.species = species;
      place.setPose(*reached[roomOf[body]][species]);
    }
    std::vector<std::int64_t> sorted = members;
    std::sort(sorted.begin(), sorted.end());
    if (StepHalving(scene_).examine(swapped, sorted).clean()) state_ = std::move(swapped);
  }

  /// Tries another body in the room of a cell, or the same one rotated, and keeps it if that gains volume.
  bool take(std::int64_t cell, int species) {
    const std::optional<Pose> pose = rooms_.largest(state_, cell, species, stop_);
    if (!pose || volume(species, pose->scale) <= (1.0 + leastGain) * volumeOf(cell)) return false;
    state_[cell].species = species;
    state_[cell].setPose(*pose);
    return true;
  }

  void enlarge(EscapePhase& phase) {
    for (const std::int64_t cell : lacking()) {
      if (stopped()) return;
      ++phase.tried;
      const double before = volumeOf(cell);
      rooms_.enlarge(state_, cell, stop_);
      if (state_[cell].scale < 1.0) take(cell, state_[cell].species);
      phase.changed += volumeOf(cell) > before;
    }
  }

  /// Species in the reserve, in descending order of size.
  std::vector<int> inStock() const {
    std::vector<int> species;
    for (std::size_t s = 0; s < reserve_.size(); ++s)
      if (reserve_[s] > 0) species.push_back(static_cast<int>(s));
    std::stable_sort(species.begin(), species.end(),
                     [&](int a, int b) { return volume(a, 1.0) > volume(b, 1.0); });
    return species;
  }

  void replace(EscapePhase& phase) {
    for (const std::int64_t cell : lacking()) {
      if (stopped()) return;
      ++phase.tried;
      const int first = state_[cell].species;
      for (const int species : inStock())
        if (species != state_[cell].species && volume(species, 1.0) > volumeOf(cell)) take(cell, species);
      if (state_[cell].species == first) continue;
      ++phase.changed;
      ++reserve_[first];
      --reserve_[state_[cell].species];
    }
  }

  void growAll(EscapePhase& phase) {
    if (lacking().empty()) return;
    GrowthSettings last = growth_;
    last.barriers = {growth_.barriers.back()};
    last.initialScale = 0.0;
    last.giveUpAfter = 1;
    GrowthCallbacks callbacks;
    callbacks.stop = stop_;
    GrowthStatistics statistics;
    const std::vector<std::int64_t> cells = lacking();
    std::vector<double> before;
    for (const std::int64_t cell : cells) before.push_back(state_[cell].scale);
    for (std::size_t i = 0; i < state_.size(); ++i) state_[i].id = static_cast<std::int64_t>(i);
    grow(scene_, last, *planeFunction_, callbacks, state_, statistics);
    phase.tried = static_cast<std::int64_t>(cells.size());
    for (std::size_t k = 0; k < cells.size(); ++k) phase.changed += state_[cells[k]].scale > before[k];
  }

  void fillHoles(EscapePhase& phase) {
    std::vector<int> species = inStock();
    if (species.empty()) return;
    const double least = std::cbrt(0.75 / M_PI * holeFraction * volume(species.back(), 1.0));
    for (const Sphere& hole : findHoles(scene_, state_, least)) {
      if (phase.tried == settings_.holes || stopped()) return;
      ++phase.tried;
      const double room = 4.0 / 3.0 * M_PI * hole.radius * hole.radius * hole.radius;
      for (const int s : inStock()) {
        if (room < holeFraction * volume(s, 1.0)) continue;
        const auto cell = static_cast<std::int64_t>(state_.size());
        state_.push_back(makeBody(cell, s, Pose{1.0, Quaternion::Identity(), hole.center}));
        const std::optional<Pose> pose = rooms_.largest(state_, cell, s, stop_);
        if (pose && pose->scale == 1.0) {
          state_[cell].setPose(*pose);
          --reserve_[s];
          ++phase.changed;
          break;
        }
        state_.pop_back();
      }
    }
  }

  const GrowthScene& scene_;
  const GrowthSettings& growth_;
  const EscapeSettings& settings_;
  const std::function<bool()>& stop_;
  const std::function<void(const std::vector<Body>&)>& observe_;
  std::vector<std::int64_t> reserve_;  ///< bodies left, per species
  std::vector<Body>& state_;
  std::unique_ptr<PlaneFunction> planeFunction_;
  Rooms rooms_;
  std::vector<EscapePhase> phases_;
};

}  // namespace

std::vector<EscapePhase> escape(const GrowthScene& scene, const GrowthSettings& growth,
                                const EscapeSettings& settings, const PlaneFunctionFactory& factory,
                                const std::function<bool()>& stop,
                                const std::function<void(const std::vector<Body>&)>& observe,
                                std::vector<Body>& state) {
  return Escape(scene, growth, settings, factory, stop, observe, state)();
}

}  // namespace packmesh
