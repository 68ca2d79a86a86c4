// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Points on a shape's surface, in clusters that can be culled together.
#pragma once

#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Sample points of a surface in the body frame [µm], grouped into spatially compact clusters of `width`, as
/// structure of arrays. A cluster of fewer points repeats its own, each as often as the others to within one:
/// where there are several clusters, no point stands more than twice.
struct SamplePoints {
  static constexpr int width = 16;

  int clusters = 0;
  std::vector<float> x, y, z;                            ///< clusters * width
  std::vector<float> centerX, centerY, centerZ, radius;  ///< bounding spheres, padded to a multiple of width
};

/// Samples the surface of `mesh` by its vertices and, where edges are longer than `spacing` [µm], by points
/// on its triangles, so that no point of the surface is further than about `spacing` from a sample.
SamplePoints sampleSurface(const TriangleMesh& mesh, double spacing);

/// Every fourth vertex or so, spread evenly: enough to part cells that reach deep into each other.
SamplePoints sampleCoarsely(const TriangleMesh& mesh);

}  // namespace packmesh
