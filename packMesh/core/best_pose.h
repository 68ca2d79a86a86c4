// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The rigid motion between two forms of a cell.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "packMesh/core/pose.h"

namespace packmesh {

/// The rigid motion with the least sum of squared distances (Umeyama, IEEE Trans. Pattern Anal. 13, 376,
/// 1991) of points to others. Pre: as many of both, at least three
inline Pose bestPose(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  const auto matrix = [](const std::vector<Vec3>& points) {
    return Eigen::Map<const Eigen::Matrix3Xd>(points.front().data(), 3, Eigen::Index(points.size()));
  };
  const Eigen::Matrix4d best = Eigen::umeyama(matrix(from), matrix(to), false);
  Pose pose;
  pose.orientation = Quaternion(Mat3(best.topLeftCorner<3, 3>())).normalized();
  pose.position = best.topRightCorner<3, 1>();
  return pose;
}

}  // namespace packmesh
