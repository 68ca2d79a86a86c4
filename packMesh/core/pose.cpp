// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/pose.h"

#include <Eigen/Geometry>

namespace packmesh {

Pose bestPose(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  const auto matrix = [](const std::vector<Vec3>& points) {
    return Eigen::Map<const Eigen::Matrix3Xd>(points.front().data(), 3, Eigen::Index(points.size()));
  };
  const Eigen::Matrix4d best = Eigen::umeyama(matrix(from), matrix(to), false);
  Pose pose;
  pose.orientation = Quaternion(Mat3(best.topLeftCorner<3, 3>())).normalized();
  pose.position = Vec3(best.col(3).data());
  return pose;
}

}  // namespace packmesh
