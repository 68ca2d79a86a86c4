// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What the cells of a species may do and where they may be.
#pragma once

#include <memory>
#include <optional>

#include "packMesh/container/region.h"
#include "packMesh/core/pose.h"

namespace packmesh {

/// Directions that the axis of a cell may have: the y axis of its mesh, the thin one of red cells and
/// platelets. Both ends of an axis count alike.
struct AxisCone {
  Vec3 axis = Vec3::UnitY();  ///< unit vector
  double spread = 0.0;        ///< largest angle between the cell's axis and this one [rad]

  /// Angle between the axis of a cell so turned and this one [rad], at most π/2.
  double angle(const Quaternion& orientation) const;
  /// `orientation` turned as little as brings the axis into the cone.
  Quaternion nearest(const Quaternion& orientation) const;
};

/// Constraints on the cells of a species; default: none.
struct Freedom {
  bool fixed = false;  ///< cells stay where they start
  std::optional<AxisCone> cone;
  std::shared_ptr<const Region> region;  ///< centres stay inside; nullptr: anywhere
  double extraWallClearance = 0.0;       ///< from the wall, on top of what all cells keep [µm]

  bool isFree() const { return !fixed && !cone && !region && extraWallClearance == 0.0; }
};

}  // namespace packmesh
