// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Winding number of a closed surface around a point, for tests by brute force.
#pragma once

#include <cmath>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Solid angle [sr] subtended by `triangles` at `p`, after Van Oosterom and Strackee, IEEE Trans. Biomed.
/// Eng. 30, 1983: 4π for p inside a closed surface that is oriented outwards, 0 outside, -4π inside one that
/// is oriented inwards. Not exact near the surface.
inline double solidAngle(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles,
                         const Vec3& p) {
  double half = 0.0;
  for (const Triangle& t : triangles) {
    const Vec3 a = vertices[t[0]] - p, b = vertices[t[1]] - p, c = vertices[t[2]] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    half += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return 2.0 * half;
}

}  // namespace packmesh
