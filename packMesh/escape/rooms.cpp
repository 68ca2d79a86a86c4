// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/escape/rooms.h"

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

Rooms::Rooms(const GrowthScene& scene, const GrowthSettings& settings, const PlaneFunctionFactory& factory,
             int orientations)
    : scene_(scene), growth_(scene, settingsOfTrials(settings), factory), orientations_(orientations) {}

std::optional<Pose> Rooms::largest(const std::vector<Body>& state, std::int64_t cell, int species,
                                   const std::function<bool()>& stop) {
  std::optional<Pose> best;
  StepHalving judge(scene_);
  for (int k = 0; k < orientations_; ++k) {
    std::vector<Body> trial = state;
    trial[cell].species = species;
    Pose pose = trial[cell].pose();
    if (scene_.rotate) {
      const auto u =
          uniform4(scene_.seed, RandomStream::orientation, static_cast<std::uint64_t>(cell), ++trials_);
      pose.orientation = uniformRotation(u[0], u[1], u[2]);
      const Freedom* freedom = scene_.freedomOf(species);
      if (freedom && freedom->cone) pose.orientation = freedom->cone->nearest(pose.orientation);
    }
    pose.scale = firstScale;
    bool fits = false;
    for (int halving = 0; halving < halvings && !fits; ++halving, pose.scale *= fits ? 1.0 : 0.5) {
      trial[cell].setPose(pose);
      fits = judge.examine(trial, {cell}).clean();
    }
    if (!fits) continue;
    const bool full = growth_.grow({cell}, stop, trial, statistics_);
    if (!best || trial[cell].scale > best->scale) best = trial[cell].pose();
    if (full || !scene_.rotate) break;
  }
  return best;
}

void Rooms::enlarge(std::vector<Body>& state, std::int64_t cell, const std::function<bool()>& stop) {
  growth_.grow({cell}, stop, state, statistics_);
}

bool Rooms::neighbours(const std::vector<Body>& state, std::int64_t a, std::int64_t b) const {
  const std::vector<std::int64_t> near = growth_.neighboursOf({a}, state, scene_.clearance);
  return std::binary_search(near.begin(), near.end(), b);
}

}  // namespace packmesh
