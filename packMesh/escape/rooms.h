// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Sizes that bodies reach in the place of a cell.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "packMesh/growth/local_growth.h"

namespace packmesh {

/// The room of a cell, its CDT cell: the space around it up to the surfaces of its neighbours, which are
/// fixed.
class Rooms {
 public:
  /// References the scene, which must outlive this object.
  /// @param orientations number of random initial orientations per trial
  Rooms(const GrowthScene& scene, const GrowthSettings& settings, const PlaneFunctionFactory& factory,
        int orientations);

  /// The largest size that a body of `species` reaches in the room of `cell` in its place: the suitability
  /// score of thesis 3.1.3. Planes are recomputed as it grows.
  /// @return its pose; empty if not even a small one fits
  std::optional<Pose> largest(const std::vector<Body>& state, std::int64_t cell, int species,
                              const std::function<bool()>& stop);

  /// Grows `cell` from its present pose. Never lowers its scale.
  void enlarge(std::vector<Body>& state, std::int64_t cell, const std::function<bool()>& stop);

  /// True if two cells could meet.
  bool neighbours(const std::vector<Body>& state, std::int64_t a, std::int64_t b) const;

  const GrowthStatistics& statistics() const { return statistics_; }

 private:
  const GrowthScene& scene_;
  LocalGrowth growth_;
  int orientations_;
  std::uint32_t trials_ = 0;
  GrowthStatistics statistics_;
};

}  // namespace packmesh
