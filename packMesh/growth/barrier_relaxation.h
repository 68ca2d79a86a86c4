// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What un-stalls growth: all cells at the barrier's scale, pushed apart.
#pragma once

#include <functional>

#include "packMesh/growth/growth_state.h"
#include "packMesh/growth/step_halving.h"

namespace packmesh {

/// All cells of `state` at `scale`, relaxed as rigid bodies for at most `sweeps` sweeps; pairs that fail the
/// exact test are relaxed again with more clearance.
/// @param stop polled between sweeps
/// @return whether the exact test found the result free of overlap; otherwise `state` is as it was
bool relaxAtScale(const GrowthScene& scene, double scale, int sweeps, const std::function<bool()>& stop,
                  StepHalving& judge, GrowthState& state);

}  // namespace packmesh
