// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Sizes that bodies reach in the place of a cell.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "packMesh/cat/local_growth.h"

namespace packmesh {

/// The room of a cell, its CAT cell: the space around it up to the surfaces of its neighbours, which are
/// fixed.
class Rooms {
 public:
  /// References `physics`, which must outlive this object.
  /// @param orientations number of random initial orientations per trial
  Rooms(const Physics& physics, const Execution& execution, const GrowthSettings& settings,
        const PlaneFunctionFactory& factory, int orientations);

  /// Numbers so far, which determine the random numbers of the next trial.
  struct Counters {
    std::int64_t trials = 0, iterations = 0;
  };
  /// What the trials of a part of the state have in common.
  struct Trials {
    LocalGrowth::Permitted permitted;
    std::function<bool()> stop;
    Counters counters;
  };

  /// The largest size that a body of `species` reaches in the room of `cell` in its place: the suitability
  /// score of thesis 3.1.3. Planes are recomputed as it grows.
  /// @param state changed only during the call
  /// @return its pose; empty if not even a small one fits
  std::optional<Pose> largest(std::vector<Body>& state, std::int64_t cell, int species, Trials& trials);

  /// Grows `cell` from its present pose. Never lowers its scale. @return whether it has its full size
  bool enlarge(std::vector<Body>& state, std::int64_t cell, Trials& trials);

  /// True if two cells could meet.
  bool neighbours(const Body& a, const Body& b) const { return growth_.near(a, b, physics_.clearance); }

  /// Whether these cells (indices, ascending) violate nothing.
  bool valid(const std::vector<std::int64_t>& cells, const std::vector<Body>& state) const {
    return growth_.valid(cells, state);
  }

 private:
  const Physics& physics_;
  LocalGrowth growth_;
  int orientations_;
};

}  // namespace packmesh
