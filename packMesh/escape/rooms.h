// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What fits where one cell is.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "packMesh/growth/local_growth.h"

namespace packmesh {

/// The room around a cell, its CDT cell: up to the surfaces of its neighbours, which stay.
class Rooms {
 public:
  /// References the scene, which must outlive this.
  /// @param orientations random ones that each trial begins with
  Rooms(const GrowthScene& scene, const GrowthSettings& settings, const PlaneFunctionFactory& factory,
        int orientations);

  /// The largest that a body of `species` gets in the room of `cell`, instead of it: the suitability score of
  /// thesis 3.1.3. Planes are made anew as it grows.
  /// @return its pose; nothing when it would not even fit in when small
  std::optional<Pose> largest(const std::vector<Body>& state, std::int64_t cell, int species,
                              const std::function<bool()>& stop);

  /// Lets `cell` grow where it is. Never lowers its scale.
  void enlarge(std::vector<Body>& state, std::int64_t cell, const std::function<bool()>& stop);

  /// Whether two cells could meet.
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
