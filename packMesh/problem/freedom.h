// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Constraints on the motion of the cells of a species.
#pragma once

#include <memory>
#include <optional>

#include "packMesh/container/region.h"
#include "packMesh/core/pose.h"

namespace packmesh {

/// Allowed directions of the axis of a cell: the y axis of its mesh, which is the symmetry axis of red cells
/// and platelets. The two ends of an axis are equivalent.
struct AxisCone {
  Vec3 axis = Vec3::UnitY();  ///< unit vector
  double spread = 0.0;        ///< largest angle between the cell's axis and this one [rad]

  /// Angle between the axis of a cell with this orientation and this one [rad], at most π/2.
  double angle(const Quaternion& orientation) const;
  /// `orientation` after the smallest rotation that brings the axis into the cone.
  Quaternion nearest(const Quaternion& orientation) const;
};

/// A layer along a wall that membranes stay out of. It is not part of the certificate: relaxation observes it
/// up to its tolerances and the interpolation of the distance.
struct FreeLayer {
  std::shared_ptr<const Wall> wall;
  double thickness = 0.0;  ///< [µm]
};

/// Constraints on the cells of a species; default: none.
struct Freedom {
  bool fixed = false;  ///< cells stay where they start
  std::optional<AxisCone> cone;
  std::shared_ptr<const Region> region;  ///< cell centres stay inside; nullptr: anywhere
  std::optional<FreeLayer> freeLayer;
  double extraWallClearance = 0.0;  ///< clearance to the wall in addition to that of all cells [µm]

  bool isFree() const { return !fixed && !cone && !region && !freeLayer && extraWallClearance == 0.0; }
};

}  // namespace packmesh
