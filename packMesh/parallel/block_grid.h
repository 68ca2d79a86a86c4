// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Decomposition of the domain into fixed blocks.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "packMesh/core/box.h"

namespace packmesh {

/// Uniform blocks over a container's bounds. They depend only on the problem, not on the number of ranks.
///
/// Blocks of one colour can be processed concurrently: no other block of the colour reads or changes what a
/// block changes (its own cells and those within its interaction range), because every edge is at least twice
/// the interaction range and, along periodic axes, the number of blocks is one or even.
class BlockGrid {
 public:
  static constexpr int colours = 8;

  /// @param interactionRange largest distance between the centres of interacting cells [µm]
  /// @param preferredEdge edge length of blocks if the interaction range permits it [µm]
  BlockGrid(const Box& bounds, const Vec3& period, double interactionRange, double preferredEdge);

  int count() const { return blocks_[0] * blocks_[1] * blocks_[2]; }
  std::array<int, 3> counts() const { return blocks_; }

  Box boxOf(int block) const;

  /// The block of a point; points outside the bounds belong to the nearest block.
  int blockOf(const Vec3& p) const;

  /// Colour of a block: 0 ... colours - 1.
  int colourOf(int block) const;

  /// True if at least one block has this colour.
  bool has(int colour) const;

  /// Largest permitted interaction range [µm]; infinite with a single block.
  double largestRange() const;

  std::array<int, 3> indexOf(int block) const;

  /// Where the block is along a space-filling curve (Morton 1966): neighbours along it are near each other.
  std::uint64_t curvePosition(int block) const;

  /// The block and its neighbours, across periodic faces too; sorted, without repetition.
  std::vector<int> around(int block) const;

  /// Step to an adjacent block along each axis: forward (1), back (-1) or none (0).
  using Step = std::array<std::int8_t, 3>;
  struct Neighbor {
    int block;
    Step step;
  };
  /// The neighbours in all directions, across periodic faces too. A block can occur more than once, in
  /// different directions; even the block itself can.
  std::vector<Neighbor> neighbors(int block) const;

  /// Squared distances between a point in a block and the block's faces [µm²], per axis the face before it,
  /// 0, and the face behind it.
  using FaceDistances = std::array<std::array<double, 3>, 3>;
  FaceDistances faceDistances(const Vec3& p, int block) const;

  /// Squared distance between a point in a block and that block's neighbour in direction `step` [µm²].
  static double squaredDistance(const FaceDistances& ofPoint, const Step& step) {
    return ofPoint[0][step[0] + 1] + ofPoint[1][step[1] + 1] + ofPoint[2][step[2] + 1];
  }

  /// Squared distance between a point, or its nearest periodic image, and a block [µm²]; 0 inside.
  double squaredDistance(const Vec3& p, int block) const;

 private:
  Box bounds_;
  Vec3 blocksPerLength_;
  std::array<int, 3> blocks_;
  std::array<bool, 3> periodic_;
};

}  // namespace packmesh
