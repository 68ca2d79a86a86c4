// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Signed distance to a closed mesh, sampled on a grid.
#pragma once

#include <cstddef>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/field/sampled_distance.h"
#include "packMesh/mesh/mesh_tree.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/parallel/threads.h"

namespace packmesh {

/// Signed distance (positive outside, µm) to a closed mesh at the nodes of a uniform grid; node (i,j,k) is at
/// origin + spacing*(i,j,k) and has index i + nodes[0]*(j + nodes[1]*k). Dense storage instead of Bricks,
/// because the surface is near most nodes and kernels read one array.
struct DistanceGrid {
  Vec3 origin = Vec3::Zero();
  double spacing = 1.0;      ///< [µm]
  int nodes[3] = {0, 0, 0};  ///< at least 2 each
  std::vector<float> value;  ///< [µm]

  /// Trilinear interpolation; outside the grid the value at the nearest point of it plus the distance to it.
  ///
  /// A distance changes by at most as much as the point moves; therefore, with exact values at the nodes, the
  /// error of the interpolant within the grid is nowhere larger than interpolationError(), and about spacing²
  /// times the mean curvature divided by 4 where the surface is smooth.
  double distance(const Vec3& p) const { return sample(p).distance; }

  /// distance() and its gradient (not normalised) at once.
  DistanceSample sample(const Vec3& p) const {
    const GridCell cell((p - origin) / spacing, {nodes[0] - 1, nodes[1] - 1, nodes[2] - 1});
    const std::size_t row = nodes[0], slab = row * nodes[1];
    const float* low = value.data() + cell.node[0] + row * cell.node[1] + slab * cell.node[2];
    const auto at = cell.interpolate(row, slab, [&](std::size_t n) { return low[n]; });
    DistanceSample sample{at.value, Vec3(at.slope) / spacing};
    if (cell.isBeyond) {
      const Vec3 beyond = spacing * cell.beyond;
      const double length = beyond.norm();
      for (int k = 0; k < 3; ++k)
        if (beyond[k] != 0.0) sample.gradient[k] = beyond[k] / length;
      sample.distance += length;
    }
    return sample;
  }

  /// Bound of |distance() - true distance| within the grid, for exact values at the nodes [µm]: the weights w
  /// of the nodes x give sum w |p-x| <= sqrt(sum w |p-x|²) = spacing * sqrt(sum over axes t(1-t)).
  double interpolationError() const { return 0.8660254037844387 * spacing; }

  Box box() const { return {origin, origin + spacing * Vec3(nodes[0] - 1, nodes[1] - 1, nodes[2] - 1)}; }
};

/// A grid that covers `region`, with distances 0.
/// @throws InputError if it would need more than 2 GB, or there is no region or spacing
DistanceGrid emptyGrid(const Box& region, double spacing);

/// Samples the signed distance to `mesh` on a grid of the given spacing that covers `region`. Distances are
/// exact (up to rounding to float) at nodes within `band` of the surface, and always within two spacings;
/// further away they are at least the distance to the surface, at most 2 % more, and of the right sign. (The
/// band costs about 0.3 µs for each of its nodes, which the threads share; the rest a third of that.)
/// Pre: mesh closed and oriented outwards (components may be nested, see repairClosed).
/// @throws InputError as emptyGrid()
DistanceGrid sampleDistance(const MeshHierarchy& mesh, const Box& region, double spacing, double band,
                            const Threads& threads = {});

/// As sampleDistance(), in a tenth of the time: distances are exact at nodes within a spacing of the surface,
/// too large by up to a quarter of a spacing within one and a half, and by up to three quarters elsewhere.
/// Pre: mesh closed and oriented outwards, inside `region`
DistanceGrid sampleRoughly(const TriangleMesh& mesh, const Box& region, double spacing);

}  // namespace packmesh
