// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HemoCell's lattice: placement of an STL and determination of fluid nodes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Largest number of nodes that fits into memory: 2^31 flags are 256 MB.
constexpr double mostNodes = 2147483648.0;

/// Region in which HemoCell keeps vertices, for a lattice with `nodes` nodes: (lo, hi] = (-0.5, n - 0.5] on
/// every axis, times dx [µm].
inline Box keptRegion(const std::array<int, 3>& nodes, double dx) {
  return {Vec3::Constant(-0.5 * dx), dx * (Vec3(nodes[0], nodes[1], nodes[2]).array() - 0.5)};
}

constexpr std::uint64_t allBits = ~std::uint64_t(0);

/// The bits of word w of a row that represent nodes.
inline std::uint64_t usedBits(int nodes, int w) {
  const int used = nodes - 64 * w;
  return used >= 64 ? allBits : used <= 0 ? 0 : (std::uint64_t(1) << used) - 1;
}

/// Nodes of HemoCell's lattice with their flags; node (i,j,k) is at (i,j,k)·dx µm in the coordinate system of
/// .pos files.
///
/// One bit per node; each row along x starts with a new word, whose unused bits are 0.
class Lattice {
 public:
  /// Initially all nodes are fluid.
  /// @param dx lattice spacing [µm]
  /// @throws InputError if an axis has no node, there are more than 2^31 nodes, or dx is not positive and
  /// finite
  Lattice(std::array<int, 3> nodes, double dx);

  std::array<int, 3> nodes() const { return nodes_; }
  double dx() const { return dx_; }  ///< [µm]
  /// Pre: the node exists.
  bool fluid(int i, int j, int k) const { return word(i >> 6, j, k) >> (i & 63) & 1u; }
  void setFluid(int i, int j, int k, bool fluid);
  /// Sets the flags of the nodes from..to (inclusive, clipped to the lattice) of one row.
  void setFluid(int from, int to, int j, int k, bool fluid);
  /// Makes the nodes fluid that are fluid on any rank. All ranks call, with as many nodes.
  void uniteFluid(const Communicator& ranks) { ranks.unite(words_); }
  std::int64_t fluidNodes() const;
  bool hasFluidNodes() const;
  /// The range of the fluid nodes, corners included. Nothing if there are none.
  std::optional<std::array<std::array<int, 3>, 2>> fluidRange() const;
  double fluidVolume() const;  ///< fluid nodes · dx³ [µm³]
  /// Region in which HemoCell keeps vertices [µm].
  Box keptRegion() const { return packmesh::hemocell::keptRegion(nodes_, dx_); }

  /// The lattice whose fluid nodes are those fluid nodes of this one that have no solid node within ±radius
  /// on every axis (a cube). Nonexistent nodes are not solid.
  Lattice eroded(int radius) const;

  /// The lattice extended by `margin` nodes of its periodic images at both ends of each axis.
  Lattice repeated(const std::array<int, 3>& margin) const;

  /// Flags of one row along x: node i is bit i % 64 of word i / 64.
  const std::uint64_t* row(int j, int k) const { return &words_[rowStart(j, k)]; }
  /// Word w of that row.
  std::uint64_t word(int w, int j, int k) const { return words_[rowStart(j, k) + w]; }
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

/// A vessel STL placed as by HemoCell.
struct VesselOnLattice {
  TriangleMesh surface;  ///< in the coordinate system of .pos files [µm], outward, not inflated
  Lattice lattice;       ///< flags of the inflated surface, with both x ends opened
  double period = 0.0;   ///< n_x · dx [µm]
};

/// HemoCell's mapping from STL units to the coordinate system of .pos files, and its voxelisation.
/// Pre: `stl` closed and outward (see repairClosed).
/// @param asRead the mesh as in the file, if repairs changed it: HemoCell inflates and fills that mesh. Must
/// satisfy isFilledByParity()
/// @param dx lattice spacing [µm]
/// @param refDir reference direction 0, 1, 2
/// @param refDirN number of nodes along refDir
/// @throws InputError if refDir or refDirN is invalid or gives a lattice of more than 2^31 nodes
VesselOnLattice placeVessel(TriangleMesh stl, double dx, int refDir, int refDirN,
                            const TriangleMesh* asRead = nullptr);

/// True if every ray that meets no edge crosses the mesh an even number of times: every edge has an even
/// number of triangles, in any orientation.
bool isFilledByParity(const TriangleMesh& mesh);

/// What a closed surface encloses, given in lattice units; as often as it does, in whatever sense it winds
/// around it. Along the rows of nodes: exact along x [nodes³].
double enclosedVolume(const TriangleMesh& surface);

/// Marks the nodes inside or on a closed surface, given in lattice units, as fluid; the others are unchanged.
/// Every ray along x crosses the surface an even number of times, even through edges and vertices. Pre:
/// closed.
void fillInside(Lattice& lattice, const TriangleMesh& surface);

/// Distance by which HemoCell moves every vertex of templates and vessels outwards, in lattice units.
inline constexpr double inflation = 1e-3;

/// Moves each vertex by `distance` along the normalised unweighted mean of the unit normals of its faces. As
/// in HemoCell, sequentially and in place: later vertices see their neighbours already moved.
void inflate(TriangleMesh& mesh, double distance);

}  // namespace packmesh::hemocell
