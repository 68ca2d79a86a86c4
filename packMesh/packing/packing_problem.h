// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The input of a packing: plain data, no file formats.
#pragma once

#include <memory>
#include <optional>

#include "packMesh/packing/packing_state.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

class Engine;

struct PackingProblem {
  Physics physics;  ///< what is to be packed
  std::shared_ptr<const Engine>
      engine;  ///< nullptr: cells of full size are placed at random and pushed apart
  Execution execution;
  /// Saved state to resume from; empty: start from the beginning. The rest of the run is the same as without
  /// the interruption. Pre: of the same physics and engine.
  std::optional<PackingState> resume = {};
  std::optional<Checkpoints> checkpoints = {};
};

}  // namespace packmesh
