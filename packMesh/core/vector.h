// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Types of small vectors. Lengths are in µm.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace packmesh {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quaternion = Eigen::Quaterniond;

}  // namespace packmesh
