// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/regrowth.h"

#include <algorithm>
#include <set>

#include "packMesh/core/timer.h"

namespace packmesh {
namespace {

/// Scale taken off cells that meet, doubled each time they still do, and how often.
constexpr double firstShrink = 0.0025;
constexpr int shrinks = 7;

std::vector<std::int64_t> offenders(const Certificate& faults) {
  std::set<std::int64_t> cells;
  for (const OverlappingPair& pair : faults.overlapping) cells.insert({pair.first, pair.second});
  for (const MisplacedCell& cell : faults.misplaced) cells.insert(cell.cell);
  return {cells.begin(), cells.end()};
}

/// Shrinks offending cells until there are none.
/// @return those that were shrunk; nothing when some still meet
std::vector<std::int64_t> shrinkToSafety(const GrowthScene& scene, const Certificate& faults,
                                         GrowthState& state, RegrowthSums& sums) {
  StepBack judge(scene);
  std::set<std::int64_t> shrunk;
  std::vector<std::int64_t> offending = offenders(faults);
  double step = firstShrink;
  for (int round = 0; round < shrinks && !offending.empty(); ++round, step *= 2.0) {
    for (const std::int64_t i : offending) {
      state[i].pose.scale -= step;
      sums.smallest = std::min(sums.smallest, state[i].pose.scale);
      shrunk.insert(i);
    }
    offending = offenders(judge.examine(state, {shrunk.begin(), shrunk.end()}));
  }
  if (!offending.empty()) return {};
  return {shrunk.begin(), shrunk.end()};
}

/// The parts of `cells` that are connected by being neighbours.
std::vector<std::vector<std::int64_t>> clustersOf(const std::vector<std::int64_t>& cells,
                                                  const GrowthState& state, const LocalGrowth& growth) {
  std::set<std::int64_t> left(cells.begin(), cells.end());
  std::vector<std::vector<std::int64_t>> clusters;
  while (!left.empty()) {
    std::vector<std::int64_t> cluster{*left.begin()};
    left.erase(left.begin());
    for (std::size_t k = 0; k < cluster.size(); ++k)
      for (const std::int64_t near : growth.neighboursOf({cluster[k]}, state, 0.0))
        if (left.erase(near)) cluster.push_back(near);
    std::sort(cluster.begin(), cluster.end());
    clusters.push_back(std::move(cluster));
  }
  return clusters;
}

}  // namespace

bool regrow(const GrowthScene& scene, const GrowthSettings& settings, const BuilderFactory& factory,
            const std::function<bool()>& stop, const Certificate& faults, GrowthState& state,
            RegrowthSums& sums) {
  const Timer watch(sums.seconds);
  ++sums.rounds;
  const GrowthState before = state;
  const std::vector<std::int64_t> shrunk = shrinkToSafety(scene, faults, state, sums);
  if (shrunk.empty()) {
    state = before;
    return faults.clean();
  }
  sums.cells += static_cast<std::int64_t>(shrunk.size());
  LocalGrowth growth(scene, settings, factory);
  for (const std::vector<std::int64_t>& cluster : clustersOf(shrunk, state, growth)) {
    ++sums.clusters;
    // Mostly they find a way alone, which costs a tenth of what it takes when neighbours make way.
    if (growth.grow(cluster, MakingWay::nobody, stop, state, sums.growth)) {
      ++sums.alone;
      continue;
    }
    if (growth.grow(cluster, MakingWay::neighbours, stop, state, sums.growth)) continue;
    ++sums.unfinished;
    state = before;
    return false;
  }
  return true;
}

}  // namespace packmesh
