// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HemoCell's lattice: how an STL becomes nodes, and which nodes are fluid.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "packMesh/geometry/box.h"
#include "packMesh/geometry/triangle_mesh.h"

namespace packmesh::hemocell {

/// Nodes of HemoCell's lattice with their flags; node (i,j,k) stands at (i,j,k)·dx µm in the .pos frame.
class Lattice {
 public:
  /// All nodes fluid.
  Lattice(std::array<int, 3> nodes, double dx);

  std::array<int, 3> nodes() const { return nodes_; }
  double dx() const { return dx_; }                       ///< [µm]
  bool fluid(int i, int j, int k) const { return fluid_[index(i, j, k)]; }
  void setFluid(int i, int j, int k, bool fluid) { fluid_[index(i, j, k)] = fluid; }
  std::int64_t fluidNodes() const;
  double fluidVolume() const;                             ///< fluid nodes · dx³ [µm³]
  /// (-0.5, n - 0.5] on every axis, times dx [µm]: where HemoCell keeps vertices.
  Box keptRegion() const;

 private:
  std::int64_t index(int i, int j, int k) const { return i + std::int64_t(nodes_[0]) * (j + std::int64_t(nodes_[1]) * k); }
  std::array<int, 3> nodes_;
  double dx_;
  std::vector<bool> fluid_;
};

/// A vessel STL as HemoCell places it.
struct VesselOnLattice {
  TriangleMesh surface;   ///< in the .pos frame [µm], outward, not inflated
  Lattice lattice;        ///< flags of the inflated surface, the two x ends opened
  double period = 0.0;    ///< n_x · dx [µm]
};

/// HemoCell's mapping from STL units to the .pos frame and its voxelisation.
/// Pre: `stl` closed and outward (see repairClosed).
/// @param dx [µm], @param refDir 0, 1, 2, @param refDirN nodes along refDir
/// @throws InputError when refDir or refDirN make no lattice or one of more than 2^31 nodes
VesselOnLattice placeVessel(TriangleMesh stl, double dx, int refDir, int refDirN);

}  // namespace packmesh::hemocell
