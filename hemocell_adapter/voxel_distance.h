// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Signed distance to the region whose nodes are "fluid", a union of node-centred cubes.
#pragma once

#include <array>
#include <vector>

#include "hemocell_adapter/lattice.h"
#include "packMesh/container/container.h"

namespace packmesh::hemocell {

/// Signed distance to the boundary of the union of the cubes (node ± dx/2) of the fluid nodes of a lattice;
/// positive inside the union; everything that does not exist in the lattice is outside it.
///
/// Exact within `exactReach` nodes of the boundary, by looking at the cubes around the point; further away an
/// interpolated distance transform lowered by its largest error, so that it never exceeds the true distance.
/// The two are blended: the distance is continuous everywhere.
class VoxelDistance {
 public:
  /// @param inside a lattice whose fluid nodes make up the region; kept by reference, must outlive this
  /// object
  explicit VoxelDistance(const Lattice& inside);

  /// @param p [µm] in the frame of the lattice; anywhere
  /// @return distance [µm] and unit gradient
  WallDistance at(const Vec3& p) const;

  /// Distance up to which the result is exact [nodes].
  static constexpr double exactReach = 1.25;

 private:
  struct Near {
    double distance;  ///< to the nearest cube of the other kind or, inside, the rim of the lattice
    Vec3 gradient;    ///< unit, pointing inside
  };
  bool isInside(int i, int j, int k) const { return lattice_.fluid(i, j, k); }
  Near nearest(const Vec3& u, const std::array<int, 3>& node, bool inside) const;
  WallDistance inLattice(const Vec3& u) const;
  double interpolated(const Vec3& u, Vec3& gradient) const;

  const Lattice& lattice_;
  int step_;                      ///< nodes between samples of the transform
  std::array<int, 3> samples_;    ///< sample (i,j,k) is at node step_·(i,j,k)
  std::vector<float> transform_;  ///< signed distance at the samples [nodes]
};

/// Euclidean distance transform: signed distance [nodes] from the points step·(i,j,k) to the boundary of the
/// union of unit cubes around fluid nodes, exact to rounding; x fastest. The region beyond the lattice is
/// outside.
std::vector<float> voxelTransform(const Lattice& inside, int step, const std::array<int, 3>& samples);

}  // namespace packmesh::hemocell
