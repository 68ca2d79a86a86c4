// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HemoCell's lattice: how an STL becomes nodes, and which nodes are fluid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh::hemocell {

/// Nodes of a lattice that fit into memory: 2^31 flags are 256 MB.
constexpr double mostNodes = 2147483648.0;

/// Where HemoCell keeps vertices of a lattice with so many nodes: (lo, hi] = (-0.5, n - 0.5] on every axis,
/// times dx [µm].
inline Box keptRegion(const std::array<int, 3>& nodes, double dx) {
  return {Vec3::Constant(-0.5 * dx), dx * (Vec3(nodes[0], nodes[1], nodes[2]).array() - 0.5)};
}

/// Nodes of HemoCell's lattice with their flags; node (i,j,k) stands at (i,j,k)·dx µm in the .pos frame.
///
/// A bit per node; each row along x starts with a new word, whose unused bits are 0.
class Lattice {
 public:
  /// All nodes fluid.
  /// @param dx lattice spacing [µm]
  /// @throws InputError when there is no node on an axis, more than 2^31 in all, or dx is not positive and
  /// finite
  Lattice(std::array<int, 3> nodes, double dx);

  std::array<int, 3> nodes() const { return nodes_; }
  double dx() const { return dx_; }  ///< [µm]
  /// Pre: the node exists.
  bool fluid(int i, int j, int k) const { return row(j, k)[i >> 6] >> (i & 63) & 1u; }
  void setFluid(int i, int j, int k, bool fluid);
  /// Flags of the nodes from..to (inclusive, cut to the lattice) of one row.
  void setFluid(int from, int to, int j, int k, bool fluid);
  std::int64_t fluidNodes() const;
  double fluidVolume() const;  ///< fluid nodes · dx³ [µm³]
  /// Where HemoCell keeps vertices.
  Box keptRegion() const { return packmesh::hemocell::keptRegion(nodes_, dx_); }

  /// The lattice whose fluid nodes are the fluid nodes of this one without a solid node within ±radius on
  /// every axis (a cube). Nodes that do not exist are not solid.
  Lattice eroded(int radius) const;

  /// The lattice with so many more nodes at both ends of each axis: those of its periodic images.
  Lattice repeated(const std::array<int, 3>& margin) const;

  /// The flags of one row along x: node i is bit i % 64 of word i / 64.
  const std::uint64_t* row(int j, int k) const { return &words_[rowStart(j, k)]; }
  int wordsPerRow() const { return wordsPerRow_; }

 private:
  std::size_t rowStart(int j, int k) const {
    return static_cast<std::size_t>(wordsPerRow_) * (j + static_cast<std::size_t>(nodes_[1]) * k);
  }

  std::array<int, 3> nodes_;
  double dx_;
  int wordsPerRow_;
  std::vector<std::uint64_t> words_;
};

/// A vessel STL as HemoCell places it.
struct VesselOnLattice {
  TriangleMesh surface;  ///< in the .pos frame [µm], outward, not inflated
  Lattice lattice;       ///< flags of the inflated surface, the two x ends opened
  double period = 0.0;   ///< n_x · dx [µm]
};

/// HemoCell's mapping from STL units to the .pos frame and its voxelisation.
/// Pre: `stl` closed and outward (see repairClosed).
/// @param asRead the mesh as it is in the file, if repairs changed it: HemoCell inflates and fills that one.
/// It must
///   be filled by parity (see below)
/// @param dx [µm]
/// @param refDir 0, 1, 2
/// @param refDirN nodes along refDir
/// @throws InputError when refDir or refDirN make no lattice or one of more than 2^31 nodes
VesselOnLattice placeVessel(TriangleMesh stl, double dx, int refDir, int refDirN,
                            const TriangleMesh* asRead = nullptr);

/// Whether every ray that meets no edge crosses the mesh an even number of times: an even number of triangles
/// at every edge, however they are oriented.
bool isFilledByParity(const TriangleMesh& mesh);

/// Marks as fluid the nodes that lie inside or on a closed surface given in lattice units; leaves the others.
/// Every ray along x crosses the surface an even number of times, also through edges and vertices.
/// Pre: closed.
void fillInside(Lattice& lattice, const TriangleMesh& surface);

}  // namespace packmesh::hemocell
