// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/problem/freedom.h"

#include <algorithm>
#include <cmath>

namespace packmesh {

double AxisCone::angle(const Quaternion& orientation) const {
  const Vec3 own = orientation * Vec3::UnitY();
  return std::atan2(own.cross(axis).norm(), std::abs(own.dot(axis)));
}

Quaternion AxisCone::nearest(const Quaternion& orientation) const {
  const double beyond = angle(orientation) - spread;
  if (!(beyond > 0.0)) return orientation;
  const Vec3 own = orientation * Vec3::UnitY();
  const Vec3 towards = own.dot(axis) < 0.0 ? Vec3(-axis) : axis;
  Vec3 around = own.cross(towards);
  if (!(around.norm() > 1e-12)) return orientation;  // parallel: rotation axis undefined
  return (Quaternion(Eigen::AngleAxisd(beyond, around.normalized())) * orientation).normalized();
}

}  // namespace packmesh
