// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/rooms.h"

#include <algorithm>

#include "packMesh/core/random.h"

namespace packmesh {
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

std::optional<Pose> Rooms::largest(std::vector<Body>& state, std::int64_t cell, int species, Trials& trials) {
  std::optional<Pose> best;
  Body& body = state[cell];
  const Body before = body;
  body.species = species;
  for (int k = 0; k < orientations_; ++k) {
    Pose pose = before.pose();
    if (physics_.rotate) {
      const auto u = uniform4(physics_.seed, RandomStream::orientation, static_cast<std::uint64_t>(body.id),
                              static_cast<std::uint32_t>(++trials.counters.trials));
      pose.orientation = uniformRotation(u[0], u[1], u[2]);
      const std::optional<AxisCone>& cone = physics_.species[species].freedom.cone;
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
