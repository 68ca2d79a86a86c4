// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The input of a packing: plain data, no file formats.
#pragma once

#include <optional>

#include "packMesh/packing/method.h"
#include "packMesh/packing/packing_state.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

struct PackingProblem {
  Physics physics;  ///< what is to be packed
  Method method;
  Execution execution;
  /// Saved state to resume from; empty: start from the beginning. The rest of the run is the same as without
  /// the interruption. Pre: of the same physics and method.
  std::optional<PackingState> resume = {};
  std::optional<Checkpoints> checkpoints = {};
};

}  // namespace packmesh
