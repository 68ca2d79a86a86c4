// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Small vectors, and numbers and points as text for messages. Lengths are in µm.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <charconv>
#include <string>

namespace packmesh {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quaternion = Eigen::Quaterniond;

/// Names of the axes 0, 1, 2.
inline constexpr const char* axisName[3] = {"x", "y", "z"};

/// `value` with at most `digits` significant digits: "12.5".
inline std::string toText(double value, int digits = 6) {
  char text[64];
  return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::general, digits).ptr};
}

/// "(1, 2.5, 3)".
inline std::string toText(const Vec3& p) {
  return "(" + toText(p.x()) + ", " + toText(p.y()) + ", " + toText(p.z()) + ")";
}

}  // namespace packmesh
