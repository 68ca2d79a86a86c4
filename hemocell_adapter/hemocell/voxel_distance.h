// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Signed distance to the region whose nodes are "fluid", a union of node-centred cubes.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "hemocell_adapter/hemocell/lattice.h"
#include "packMesh/container/container.h"
#include "packMesh/field/distance_grid.h"
#include "packMesh/field/sampled_distance.h"

namespace packmesh::hemocell {

/// Signed distance to the boundary of the union of the cubes (node ± dx/2) of the fluid nodes of a lattice;
/// positive inside the union; everything beyond the lattice is outside.
///
/// Near the boundary: trilinear interpolation of exact distances at spacing dx/2. The samples lie on faces,
/// edges and centres of the cubes, so that each interpolation cell lies in one cube and **the sign is exact
/// everywhere**: distance > 0 only where the node of the point is fluid. Away from the boundary:
/// interpolation of a coarser transform, minus its largest error. The two are blended so that the distance is
/// continuous. Both are computed when needed. Threads can share it.
class VoxelDistance {
 public:
  /// @param inside must outlive this object
  explicit VoxelDistance(const Lattice& inside);

  /// @param p [µm] in the coordinate system of the lattice; any finite point
  /// @return distance [µm] and unit gradient of the interpolant
  WallDistance at(const Vec3& p) const;

  /// Distances at the samples that are first[k] + step * (0 ... count - 1 along x) half nodes from the low
  /// corner of the lattice [µm]: exact within fineReach of the boundary; NaN further away and beyond the
  /// lattice.
  void atSamples(const std::array<int, 3>& first, int step, int count, float* distances) const;

  /// Samples of a block (see atSamples): start of its rows along x, and the step.
  struct SampleRows {
    std::array<int, 3> first;
    int step;
  };
  /// Empty if the nodes of the block are not at integer multiples of half nodes.
  std::optional<SampleRows> rowsOf(const NodeBlock& block) const;

  /// Distances at the nodes of a block, x fastest: those of atSamples where available, otherwise those of
  /// at().
  void sample(const NodeBlock& block, float* distances) const;

  /// A smooth lower bound of the distance, at most smoothReach(): it follows from the share of solid nodes
  /// around p, with quadratic B-splines as weights. Where nodes on one side of a plane are solid, it is 0
  /// at 0.65 dx from the faces of their cubes; where it is positive, p is in no cube of a solid node.
  WallDistance smoothed(const Vec3& p) const;
  double smoothReach() const;  ///< [µm]

  /// Largest excess of a distance over the true one [µm]: from interpolation next to a corner of a cube.
  double slack() const { return nearError * dx_; }

  static constexpr double nearError =
      0.13;  ///< largest excess of the interpolated distance to a corner [nodes]
  static constexpr double fineReach = 2.0;  ///< up to this distance only fine samples are used [nodes]
  static constexpr double farReach = 3.0;   ///< from this distance on only coarse samples are used [nodes]

 private:
  /// Codes at the fine samples of a brick: sign · squared distance in units of (dx/2)², at most farReach;
  /// nullptr: all of it is further than that from the boundary.
  const std::int8_t* brick(const std::array<int, 3>& at) const;
  bool makeBrick(const std::array<int, 3>& at, std::int8_t* codes) const;
  WallDistance far(const Vec3& w) const;
  WallDistance inLattice(const Vec3& w) const;

  double dx_;
  std::array<int, 3> nodes_;
  const Lattice& inside_;
  mutable Bricks<std::int8_t, std::int64_t> bricks_;  ///< of fine samples
  double farError_;                 ///< largest excess of the coarse interpolation beyond fineReach [nodes]
  mutable DistanceGrid transform_;  ///< signed distance at the coarse samples [nodes]
  mutable std::once_flag transformed_;  ///< whether it has been needed yet
};

/// Euclidean distance transform: signed distance [nodes] from the corners of cubes to the boundary of the
/// union of the cubes of fluid nodes, exact up to rounding; x fastest. Sample (i,j,k) is at step·(i,j,k)
/// nodes from the low corner of the lattice, which is at -dx/2; samples can lie beyond the lattice, which is
/// outside the union.
std::vector<float> voxelTransform(const Lattice& inside, int step, const std::array<int, 3>& samples);

}  // namespace packmesh::hemocell
