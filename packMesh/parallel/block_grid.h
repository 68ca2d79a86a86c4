// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The fixed cut of the domain into blocks.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "packMesh/core/box.h"

namespace packmesh {

/// Uniform blocks over a container's bounds. They depend on the problem alone, never on the number of ranks.
///
/// Blocks of one colour can be worked on at the same time: what a block changes (its own cells and cells
/// within the interaction range of it) no other block of its colour reads or changes, because every edge is
/// at least twice the interaction range and, along periodic axes, the number of blocks is one or even.
class BlockGrid {
 public:
  static constexpr int colours = 8;

  /// @param interactionRange largest distance of two cells' centres that can act on each other [µm]
  /// @param preferredEdge edge a block should have if the range allows it [µm]
  BlockGrid(const Box& bounds, const Vec3& period, double interactionRange, double preferredEdge);

  int count() const { return blocks_[0] * blocks_[1] * blocks_[2]; }
  std::array<int, 3> counts() const { return blocks_; }

  /// The block of a point; points outside the bounds belong to the nearest block.
  int blockOf(const Vec3& p) const;

  /// 0 ... colours - 1.
  int colourOf(int block) const;

  /// Whether any block has this colour.
  bool has(int colour) const;

  /// The largest range over which cells may act on each other [µm]; infinite when there is one block.
  double largestRange() const;

  std::array<int, 3> indexOf(int block) const;

  /// Where the block is along a space-filling curve (Morton 1966): neighbours along it are near each other.
  std::uint64_t curvePosition(int block) const;

  /// The block itself and those that touch it, across periodic faces too; each once, sorted.
  std::vector<int> around(int block) const;

  /// One block further along an axis (1), one back (-1), or none (0).
  using Step = std::array<std::int8_t, 3>;
  struct Neighbor {
    int block;
    Step step;
  };
  /// What is one step away along any axes, across periodic faces too; a block can be there more than once, by
  /// different ways, even the block itself.
  std::vector<Neighbor> neighbors(int block) const;

  /// Squared distance of a point in a block from what is one step away from that block [µm²].
  double squaredDistance(const Vec3& p, int block, const Step& step) const;

 private:
  Vec3 lo_, blocksPerLength_;
  std::array<int, 3> blocks_;
  std::array<bool, 3> periodic_;
};

}  // namespace packmesh
