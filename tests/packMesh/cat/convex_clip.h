// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Convex polyhedra cut by planes: an oracle for the volumes of segments.
#pragma once

#include <array>
#include <vector>

#include "packMesh/core/vector.h"

namespace packmesh::test {

/// Convex polyhedron as its faces, each a convex polygon, counter-clockwise seen from outside.
struct ConvexBody {
  std::vector<std::vector<Vec3>> faces;

  static ConvexBody tetrahedron(const std::array<Vec3, 4>& p) {  // of positive volume
    return {{{p[0], p[2], p[1]}, {p[0], p[1], p[3]}, {p[1], p[2], p[3]}, {p[0], p[3], p[2]}}};
  }

  double volume() const {
    double sixfold = 0.0;
    if (faces.empty()) return 0.0;
    const Vec3 origin = faces[0][0];
    for (const std::vector<Vec3>& face : faces)
      for (std::size_t k = 1; k + 1 < face.size(); ++k)
        sixfold += (face[0] - origin).dot((face[k] - origin).cross(face[k + 1] - origin));
    return sixfold / 6.0;
  }

  /// Keeps what lies behind the plane: normal · (x - point) <= 0.
  void cut(const Vec3& point, const Vec3& normal) {
    std::vector<std::vector<Vec3>> kept;
    std::vector<Vec3> rim;  // the new face's corners, in pairs
    for (const std::vector<Vec3>& face : faces) {
      std::vector<Vec3> part;
      for (std::size_t k = 0; k < face.size(); ++k) {
        const Vec3 &a = face[k], &b = face[(k + 1) % face.size()];
        const double heightA = normal.dot(a - point), heightB = normal.dot(b - point);
        if (heightA <= 0.0) part.push_back(a);
        if ((heightA <= 0.0) != (heightB <= 0.0)) {
          const Vec3 crossing = a + heightA / (heightA - heightB) * (b - a);
          part.push_back(crossing);
          rim.push_back(crossing);
        }
      }
      if (part.size() >= 3) kept.push_back(part);
    }
    if (rim.size() >= 3) {
      // All corners around their middle, by angle.
      Vec3 middle = Vec3::Zero();
      for (const Vec3& p : rim) middle += p / double(rim.size());
      const Vec3 u = normal.unitOrthogonal(), v = normal.normalized().cross(u);
      std::sort(rim.begin(), rim.end(), [&](const Vec3& a, const Vec3& b) {
        return std::atan2((a - middle).dot(v), (a - middle).dot(u)) <
               std::atan2((b - middle).dot(v), (b - middle).dot(u));
      });
      kept.push_back(rim);
    }
    faces = std::move(kept);
  }
};

}  // namespace packmesh::test
