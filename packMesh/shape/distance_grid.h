// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Signed distance to a closed mesh, sampled on a grid.
#pragma once

#include <vector>

#include "packMesh/geometry/box.h"
#include "packMesh/geometry/triangle_mesh.h"

namespace packmesh {

/// Signed distance (positive outside, µm) to a closed mesh at the nodes of a uniform grid; node (i,j,k) is at
/// origin + spacing*(i,j,k) and has index i + nodes[0]*(j + nodes[1]*k).
struct DistanceGrid {
  Vec3 origin = Vec3::Zero();
  double spacing = 1.0;                 ///< [µm]
  int nodes[3] = {0, 0, 0};
  std::vector<float> value;             ///< [µm]

  /// Trilinear interpolation; outside the grid the value at the nearest point of it plus the distance to it.
  double distance(const Vec3& p) const;
  /// Gradient of the interpolant (not normalised).
  Vec3 gradient(const Vec3& p) const;
};

/// Samples the signed distance to `mesh` on a grid that covers `region` with at least the given spacing.
/// Distances are exact (to rounding) at nodes within `band` of the surface; further away they are the distance
/// to the surface to within a relative error of 2 % and of the right sign.
/// Pre: mesh closed and oriented outwards. Throws InputError when the grid would need more than 2 GB.
DistanceGrid sampleDistance(const TriangleMesh& mesh, const Box& region, double spacing, double band);

}  // namespace packmesh
