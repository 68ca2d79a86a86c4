// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The flags of a lattice in pages that are made when they are needed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "packMesh/parallel/made_once.h"

namespace packmesh::hemocell {

/// Flags of 64 x 8 x 8 nodes: word [j + 8 k] holds a row of 64 nodes along x; nodes that do not exist are 0.
using LatticePage = std::array<std::uint64_t, 64>;

/// A flag for each block of 8³ nodes.
struct BlockFlagsOfLattice {
  std::array<int, 3> blocks;
  std::vector<bool> flags;

  explicit BlockFlagsOfLattice(const std::array<int, 3>& count)
      : blocks(count), flags(std::size_t(count[0]) * count[1] * count[2], false) {}
  std::size_t at(int i, int j, int k) const { return i + blocks[0] * (j + std::size_t(blocks[1]) * k); }
  bool fluid(int i, int j, int k) const { return flags[at(i, j, k)]; }
  void setFluid(int i, int j, int k, bool fluid) { flags[at(i, j, k)] = fluid; }
};

/// The blocks of nodes that are all fluid, and those with any fluid node.
struct CoarseNodes {
  std::shared_ptr<const BlockFlagsOfLattice> all, any;
};

/// Threads can share it.
class LatticePages {
 public:
  static constexpr int nodesX = 64, nodesYZ = 8, blockNodes = 8;

  explicit LatticePages(const std::array<int, 3>& nodes)
      : nodes_(nodes), count_({(nodes[0] + 63) / 64, (nodes[1] + 7) / 8, (nodes[2] + 7) / 8}) {}
  virtual ~LatticePages() = default;

  /// Word w of the row (j, k).
  std::uint64_t word(int w, int j, int k) const {
    const LatticePage& page = pageAt({w, j / nodesYZ, k / nodesYZ});
    return page[(j % nodesYZ) + nodesYZ * (k % nodesYZ)];
  }

  /// Nodes of the lattice, and pages along each axis.
  const std::array<int, 3>& nodes() const { return nodes_; }
  const std::array<int, 3>& count() const { return count_; }
  std::int64_t number(const std::array<int, 3>& page) const {
    return page[0] + count_[0] * (page[1] + std::int64_t(count_[1]) * page[2]);
  }

  /// The blocks can be classified more cautiously than they are: fewer all fluid, more with any fluid node.
  const CoarseNodes& coarse() const { return coarse_; }
  std::size_t pagesHere() const { return pages_.size(); }

 protected:
  virtual void make(const std::array<int, 3>& page, LatticePage& out) const = 0;
  CoarseNodes coarse_;

 private:
  static std::uint64_t newName();
  const LatticePage& pageAt(const std::array<int, 3>& page) const;
  const LatticePage& found(const std::array<int, 3>& page) const;

  std::array<int, 3> nodes_, count_;
  mutable MadeOnce<std::int64_t, LatticePage> pages_;  ///< those with fluid and solid nodes
  std::uint64_t name_ = newName();                     ///< no other object has it, not even later
};

/// Pages of the nodes of another lattice that have no solid node within ±radius (see Lattice::eroded).
std::shared_ptr<const LatticePages> erodedPages(std::shared_ptr<const LatticePages> of, int radius);

/// Pages of a lattice with margins of periodic images (see Lattice::repeated).
std::shared_ptr<const LatticePages> repeatedPages(std::shared_ptr<const LatticePages> of,
                                                  const std::array<int, 3>& margin);

}  // namespace packmesh::hemocell
