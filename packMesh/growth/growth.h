// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Growth: cells shrunk to points of a start grow, each in its own planes, barrier by barrier.
#pragma once

#include <cstdint>
#include <functional>

#include "packMesh/growth/growth_settings.h"
#include "packMesh/growth/growth_state.h"
#include "packMesh/growth/step_halving.h"

namespace packmesh {

/// How a run went.
struct GrowthStatistics {
  std::int64_t iterations = 0;
  std::int64_t relaxations = 0, relaxationsKept = 0;  ///< at a barrier; whose result was free of overlap
  std::int64_t planes = 0, pivots = 0;                ///< over all iterations
  StepHalvingSums stepHalving;
  double planeSeconds = 0.0, programSeconds = 0.0, stepHalvingSeconds = 0.0,
         relaxationSeconds = 0.0;  ///< CPU [s]
};

/// How far growth has come; with the state and the number of iterations all that its future depends on.
struct GrowthProgress {
  std::int64_t barrier = 0;                             ///< which
  std::int64_t iteration = 0, since = 0, failures = 0;  ///< at this barrier: done; since it was asked whether
                                                        ///< growth stalled; relaxations in vain
  double sweeps = 0.0;                                  ///< of the next relaxation
  double reference = 0.0;                               ///< what was missing when it was asked last
  std::vector<double> taken;                            ///< part of each cell's last step; empty: all of it
};

/// When growth gives up, and whom it tells.
struct GrowthCallbacks {
  std::function<bool()> stop;  ///< polled before every iteration
  /// Called with every state that is accepted, and the barrier.
  std::function<void(const GrowthState&, double barrier, const GrowthStatistics&)> accepted;
  /// Called before every few iterations: growth can go on from there.
  std::function<void(const GrowthState&, const GrowthProgress&)> checkpoint;
};

/// Algorithm 1 of the thesis.
///
/// For each barrier: planes are built from the state, every cell grows in its own as far as the barrier,
/// steps are taken as far as no meshes meet (StepHalving), until all cells are at the barrier or the
/// iterations are used up. Every state is free of overlap by the exact test; no cell ever shrinks. When
/// growth stalls, all cells take the barrier's scale, are relaxed as rigid bodies, and if the exact test
/// finds them free of overlap this is the next state.
/// @param state free of overlap, no scale above 1; on return the last state
/// @param statistics is added to; the iterations so far decide on random numbers
/// @param from where to go on
/// @return whether all cells reached scale 1
/// @throws InputError naming the cell when the first state is not valid
bool grow(const GrowthScene& scene, const GrowthSettings& settings, const PlaneFunction& planeFunction,
          const GrowthCallbacks& callbacks, GrowthState& state, GrowthStatistics& statistics,
          const GrowthProgress& from = {});

}  // namespace packmesh
