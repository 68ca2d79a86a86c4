// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Position and orientation of a cell: Pose, the state that packing changes, and Placement, the map
/// that is output.
#pragma once

#include <vector>

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

/// The rigid motion with the least sum of squared distances (Umeyama, IEEE Trans. Pattern Anal. 13, 376,
/// 1991) of points to others. Pre: as many of both, at least three
Pose bestPose(const std::vector<Vec3>& from, const std::vector<Vec3>& to);

/// Points in the frame of a pose of scale 1.
inline std::vector<Vec3> inFrameOf(const Pose& pose, std::vector<Vec3> points) {
  const Mat3 back = pose.orientation.toRotationMatrix().transpose();
  for (Vec3& p : points) p = back * (p - pose.position);
  return points;
}

}  // namespace packmesh
