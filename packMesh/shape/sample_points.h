// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Points on a shape's surface, in clusters that are culled together.
#pragma once

#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Sample points of a surface in the body frame [µm], grouped into spatially compact clusters of `width`, as
/// structure of arrays. A cluster with fewer points repeats them equally often (up to one): if there are
/// several clusters, no point occurs more than twice.
struct SamplePoints {
  static constexpr int width = 16;

  int clusters = 0;
  std::vector<float> x, y, z;                            ///< clusters * width entries
  std::vector<float> centerX, centerY, centerZ, radius;  ///< bounding spheres, padded to a multiple of width
};

/// Samples the surface of `mesh` by its vertices and, where edges are longer than `spacing` [µm], by points
/// on its triangles, so that no point of the surface is further than about `spacing` from a sample.
SamplePoints sampleSurface(const TriangleMesh& mesh, double spacing);

/// About every fourth vertex, evenly spread: sufficient to separate cells that overlap deeply.
SamplePoints sampleCoarsely(const TriangleMesh& mesh);

/// Up to `count` vertices, each the farthest one from those before it; the first is farthest from the origin.
std::vector<Vec3> spreadPoints(const TriangleMesh& mesh, int count);

}  // namespace packmesh
