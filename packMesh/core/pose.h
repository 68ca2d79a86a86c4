// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Position and orientation of a cell: Pose, the state that packing changes, and Placement, the map
/// that is output.
#pragma once

#include "packMesh/core/vector.h"

namespace packmesh {

/// Affine map from the body frame of a template to the world: x -> linear * x + translation [µm].
///
/// Certificate and acceptance test meshes placed by a Placement, so that they apply to exactly the numbers
/// that are written to a file.
struct Placement {
  Mat3 linear = Mat3::Identity();
  Vec3 translation = Vec3::Zero();

  /// The only formula that maps template vertices to world vertices.
  Vec3 operator()(const Vec3& body) const { return linear * body + translation; }
};

/// State of one cell (thesis eq. 3.5): scale [fraction of full size], orientation, position of the template's
/// origin [µm].
struct Pose {
  double scale = 1.0;
  Quaternion orientation = Quaternion::Identity();
  Vec3 position = Vec3::Zero();

  Placement placement() const { return {scale * orientation.toRotationMatrix(), position}; }
};

}  // namespace packmesh
