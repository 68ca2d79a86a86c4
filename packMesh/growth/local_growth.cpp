// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/local_growth.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "packMesh/certificate/periodic_neighbors.h"

namespace packmesh {
namespace {

/// Expected displacement of cells in one local growth, in steps of the largest length.
constexpr double expectedSteps = 8.0;

std::vector<std::int64_t> joined(const std::vector<std::int64_t>& a, const std::vector<std::int64_t>& b) {
  std::vector<std::int64_t> out;
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(out));
  return out;
}

}  // namespace

LocalGrowth::LocalGrowth(const GrowthScene& scene, const GrowthSettings& settings,
                         const PlaneFunctionFactory& factory)
    : scene_(scene), settings_(settings), planeFunction_(factory(scene_)) {
  settings_.barriers = {settings.barriers.back()};
  settings_.relaxationSweeps = 0;
  settings_.initialScale = 0.0;
  settings_.giveUpAfter = 2;
}

std::vector<std::int64_t> LocalGrowth::neighboursOf(const std::vector<std::int64_t>& cells,
                                                    const std::vector<Body>& state, double margin) const {
  std::vector<Sphere> spheres;
  for (const Body& cell : state) spheres.push_back({cell.position, scene_.shapes[cell.species]->radius()});
  const PeriodicNeighbors neighbors(std::move(spheres), scene_.container->period());
  std::vector<char> near(state.size(), 0);
  for (const std::int64_t cell : cells)
    neighbors.forEachNear(cell, margin, false,
                          [&](const NearPair& pair) { near[pair.first] = near[pair.second] = 1; });
  for (const std::int64_t cell : cells) near[cell] = 0;
  std::vector<std::int64_t> out;
  for (std::size_t i = 0; i < near.size(); ++i)
    if (near[i]) out.push_back(static_cast<std::int64_t>(i));
  return out;
}

bool LocalGrowth::grow(const std::vector<std::int64_t>& growing, const std::function<bool()>& stop,
                       std::vector<Body>& state, GrowthStatistics& statistics) {
  double step = 0.0;
  for (const std::int64_t i : growing)
    step = std::max(step, settings_.translationBound * std::cbrt(scene_.shapes[state[i].species]->volume()));
  const double margin = expectedSteps * step + scene_.clearance;
  const std::vector<std::int64_t> members = joined(growing, neighboursOf(growing, state, margin));

  std::vector<Body> part;
  for (const std::int64_t i : members) {
    part.push_back(makeBody(static_cast<std::int64_t>(part.size()), state[i].species, state[i].pose()));
    part.back().frozen = !std::binary_search(growing.begin(), growing.end(), i);
  }
  GrowthCallbacks callbacks;
  callbacks.stop = stop;
  packmesh::grow(scene_, settings_, *planeFunction_, callbacks, part, statistics);

  const std::vector<Body> before = state;
  for (std::size_t k = 0; k < members.size(); ++k) state[members[k]].setPose(part[k].pose());
  // Some cell may have moved beyond the range in which neighbours were searched.
  StepHalving judge(scene_);
  if (!judge.examine(state, growing).clean()) {
    state = before;
    return false;
  }
  return std::all_of(growing.begin(), growing.end(), [&](std::int64_t i) { return state[i].scale == 1.0; });
}

}  // namespace packmesh
