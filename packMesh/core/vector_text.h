// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Numbers and points as text for messages, independent of the locale.
#pragma once

#include <charconv>
#include <string>

#include "packMesh/core/vector.h"

namespace packmesh {

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
