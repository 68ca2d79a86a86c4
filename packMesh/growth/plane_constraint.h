// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The constraint that both sources of growth planes produce.
#pragma once
#include <vector>
#include "packMesh/core/vector.h"
namespace packmesh {
/// The constraint that a vertex of an object stays behind a plane: normal · (T(vertex) - point) <= 0 (thesis
/// eq. 3.2).
struct PlaneConstraint {
  Vec3 vertex;  ///< body frame [µm]
  Vec3 point;   ///< on the plane, world frame, nearest image [µm]
  Vec3 normal;  ///< unit, away from the object
};
/// The planes of each object.
using PlaneConstraints = std::vector<std::vector<PlaneConstraint>>;
}  // namespace packmesh
