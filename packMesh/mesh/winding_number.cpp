// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/winding_number.h"

#include <cmath>

namespace packmesh {

double solidAngle(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles, const Vec3& p) {
  double half = 0.0;
  for (const Triangle& t : triangles) {
    const Vec3 a = vertices[t[0]] - p, b = vertices[t[1]] - p, c = vertices[t[2]] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    half += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return 2.0 * half;
}

}  // namespace packmesh
