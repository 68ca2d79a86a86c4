// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A closed prism along x as a vessel for tests.
#pragma once

#include <cmath>

#include "packMesh/mesh/triangle_mesh.h"

/// Regular prism from x = 0 to `length`, corners at `radius` from the axis, in any unit; outward.
inline packmesh::TriangleMesh prismAlongX(int corners, double radius, double length) {
  packmesh::TriangleMesh mesh;
  for (double x : {0.0, length})
    for (int c = 0; c < corners; ++c) {
      const double angle = 2.0 * M_PI * c / corners;
      mesh.vertices.emplace_back(x, radius * std::cos(angle), radius * std::sin(angle));
    }
  for (int c = 0; c < corners; ++c) {
    const int next = (c + 1) % corners;
    mesh.triangles.push_back({c, next, corners + next});
    mesh.triangles.push_back({c, corners + next, corners + c});
    if (c > 0 && next > 0) {
      mesh.triangles.push_back({0, next, c});
      mesh.triangles.push_back({corners, corners + c, corners + next});
    }
  }
  return mesh;
}
