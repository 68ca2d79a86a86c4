// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/rooms.h"

#include <algorithm>

#include "packMesh/core/random.h"
#include "packMesh/parallel/periodic_images.h"

namespace packmesh {
namespace {

/// Expected displacement of cells in one local growth, in steps of the largest length.
constexpr double expectedSteps = 8.0;

/// More than by how much writing a cell moves a point of it [µm].
constexpr double writtenDifference = 0.01;

Execution onThisRank(Execution execution) {
  execution.communicator = Communicator();
  return execution;
}

bool contains(const std::vector<std::int64_t>& ascending, std::int64_t i) {
  return std::binary_search(ascending.begin(), ascending.end(), i);
}

}  // namespace

LocalGrowth::LocalGrowth(const Physics& physics, const Execution& execution, const GrowthSettings& settings,
                         const PlaneFunctionFactory& factory)
    : physics_(physics), execution_(onThisRank(execution)), settings_(settings), planeFunction_(factory()) {
  settings_.barriers = {settings.barriers.back()};
  settings_.relaxationSweeps = 0;
  settings_.initialScale = 0.0;
  settings_.giveUpAfter = 2;
}

bool LocalGrowth::near(const Body& a, const Body& b, double margin) const {
  const double reach = physics_.shapeOf(a).radius() + physics_.shapeOf(b).radius() + std::max(0.0, margin);
  return nearestImage(b.position - a.position, physics_.container->period()).squaredNorm() < reach * reach;
}

/// The cells and those near them, ascending.
std::vector<std::int64_t> LocalGrowth::withNeighbours(const std::vector<std::int64_t>& cells,
                                                      const std::vector<Body>& state, double margin) const {
  std::vector<std::int64_t> members;
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(state.size()); ++i)
    if (contains(cells, i) || std::any_of(cells.begin(), cells.end(), [&](std::int64_t cell) {
          return near(state[cell], state[i], margin);
        }))
      members.push_back(i);
  return members;
}

bool LocalGrowth::valid(const std::vector<std::int64_t>& cells, const std::vector<Body>& state) const {
  std::vector<Body> part;
  std::vector<std::int64_t> which;
  for (const std::int64_t i : withNeighbours(cells, state, physics_.clearance + writtenDifference)) {
    if (contains(cells, i)) which.push_back(static_cast<std::int64_t>(part.size()));
    part.push_back(state[i]);
  }
  return StepHalving(physics_, execution_).examine(part, which).clean();
}

bool LocalGrowth::grow(const std::vector<std::int64_t>& growing, const std::function<bool()>& stop,
                       std::vector<Body>& state, GrowthStatistics& statistics, const Permitted& permitted) {
  double step = 0.0;
  for (const std::int64_t i : growing)
    step = std::max(step, settings_.translationBound * std::cbrt(physics_.shapeOf(state[i]).volume()));
  const std::vector<std::int64_t> members =
      withNeighbours(growing, state, expectedSteps * step + physics_.clearance);

  std::vector<Body> part;
  for (const std::int64_t i : members) {
    part.push_back(
        makeBody(static_cast<std::int64_t>(part.size()), state[i].species, state[i].shape, state[i].pose()));
    part.back().frozen = !contains(growing, i);
  }
  GrowthCallbacks callbacks;
  callbacks.stop = stop;
  packmesh::grow(physics_, execution_, settings_, *planeFunction_, callbacks, part, statistics);

  std::vector<Pose> before;
  bool full = true, kept = true;
  for (std::size_t k = 0; k < members.size(); ++k) {
    if (part[k].frozen) continue;
    before.push_back(state[members[k]].pose());
    state[members[k]].setPose(part[k].pose());
    full = full && part[k].scale == 1.0;
    kept = kept && (!permitted || permitted(part[k].position));
  }
  // Some cell may have moved beyond the range in which neighbours were searched.
  if (kept && valid(growing, state)) return full;
  for (std::size_t k = 0; k < growing.size(); ++k) state[growing[k]].setPose(before[k]);
  return false;
}

namespace {

/// Initial scale of a trial; if it does not fit, it is halved, at most `halvings` times.
constexpr double firstScale = 0.4;
constexpr int halvings = 4;

/// A trial ends when growth stalls; more iterations than this are not needed.
constexpr int iterations = 40;

GrowthSettings settingsOfTrials(GrowthSettings settings) {
  settings.maxIterations = std::min(settings.maxIterations, iterations);
  return settings;
}

}  // namespace

Rooms::Rooms(const Physics& physics, const Execution& execution, const GrowthSettings& settings,
             const PlaneFunctionFactory& factory, int orientations)
    : physics_(physics),
      growth_(physics, execution, settingsOfTrials(settings), factory),
      orientations_(orientations) {}

std::optional<Pose> Rooms::largest(std::vector<Body>& state, std::int64_t cell, const BodyKind& kind,
                                   Trials& trials) {
  std::optional<Pose> best;
  Body& body = state[cell];
  const Body before = body;
  body.species = kind.species;
  body.shape = kind.shape;
  for (int k = 0; k < orientations_; ++k) {
    Pose pose = before.pose();
    if (physics_.rotate) {
      const auto u = uniform4(physics_.seed, RandomStream::orientation, static_cast<std::uint64_t>(body.id),
                              static_cast<std::uint32_t>(++trials.counters.trials));
      pose.orientation = uniformRotation(u[0], u[1], u[2]);
      const std::optional<AxisCone>& cone = physics_.species[kind.species].freedom.cone;
      if (cone) pose.orientation = cone->nearest(pose.orientation);
    }
    pose.scale = firstScale;
    bool fits = false;
    for (int halving = 0; halving < halvings && !fits; ++halving, pose.scale *= fits ? 1.0 : 0.5) {
      body.setPose(pose);
      fits = growth_.valid({cell}, state);
    }
    if (!fits) continue;
    const bool full = enlarge(state, cell, trials);
    if (!best || body.scale > best->scale) best = body.pose();
    if (full || !physics_.rotate) break;
  }
  body = before;
  return best;
}

bool Rooms::enlarge(std::vector<Body>& state, std::int64_t cell, Trials& trials) {
  GrowthStatistics statistics;
  statistics.iterations = trials.counters.iterations;
  const bool full = growth_.grow({cell}, trials.stop, state, statistics, trials.permitted);
  trials.counters.iterations = statistics.iterations;
  return full;
}

}  // namespace packmesh
