// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Fixed blocks of the domain, the ranks that own them, and periodic images.
#pragma once

#include <array>
#include <cmath>
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

/// Blocks along a space-filling curve (Morton), divided into one section of equal work per rank. Some ranks
/// may own no blocks. Identical on all ranks.
class BlockOwners {
 public:
  /// One rank owns all blocks.
  BlockOwners() = default;
  /// @param work work of each block, in any unit; empty blocks have none
  BlockOwners(const BlockGrid& blocks, const std::vector<std::int64_t>& work, int ranks);

  int of(int block) const { return owner_.empty() ? 0 : owner_[block]; }

 private:
  std::vector<std::int32_t> owner_;
};

/// Number of periods along each axis; 0 along axes that are not periodic.
using ImageShift = std::array<std::int8_t, 3>;

inline Vec3 displacement(const ImageShift& shift, const Vec3& period) {
  return {shift[0] * period[0], shift[1] * period[1], shift[2] * period[2]};
}

/// `p` shifted by whole periods into [bounds.lo, bounds.hi) along the periodic axes.
inline Vec3 wrapped(Vec3 p, const Box& bounds, const Vec3& period) {
  for (int k = 0; k < 3; ++k)
    if (period[k] > 0.0) {
      p[k] -= period[k] * std::floor((p[k] - bounds.lo[k]) / period[k]);
      if (p[k] >= bounds.hi[k]) p[k] = bounds.lo[k];  // rounding of a tiny negative difference
    }
  return p;
}

/// The difference of two positions by the nearest images [µm].
inline Vec3 nearestImage(Vec3 between, const Vec3& period) {
  for (int k = 0; k < 3; ++k)
    if (period[k] > 0.0) between[k] -= period[k] * std::round(between[k] / period[k]);
  return between;
}

/// Calls `visit(shift)`, in a fixed order, for every shift (zero included) for which the image of a sphere of
/// radius `reach` [µm] around `p` meets the bounds. Pre: `p` is inside the bounds
template <class Visit>
void forEachImage(const Vec3& p, double reach, const Box& bounds, const Vec3& period, Visit&& visit) {
  int lo[3] = {0, 0, 0}, hi[3] = {0, 0, 0};
  for (int k = 0; k < 3; ++k)
    if (period[k] > 0.0) {
      lo[k] = static_cast<int>(std::ceil((bounds.lo[k] - reach - p[k]) / period[k]));
      hi[k] = static_cast<int>(std::floor((bounds.hi[k] + reach - p[k]) / period[k]));
    }
  for (int z = lo[2]; z <= hi[2]; ++z)
    for (int y = lo[1]; y <= hi[1]; ++y)
      for (int x = lo[0]; x <= hi[0]; ++x)
        visit(ImageShift{static_cast<std::int8_t>(x), static_cast<std::int8_t>(y),
                         static_cast<std::int8_t>(z)});
}

/// Translations to the nearest periodic images, in every combination of axes, including zero [µm].
inline std::vector<Vec3> periodicShifts(const Vec3& period) {
  const auto steps = [&](int k) { return period[k] > 0 ? std::vector<int>{-1, 0, 1} : std::vector<int>{0}; };
  std::vector<Vec3> shifts;
  for (const int i : steps(0)) {
    for (const int j : steps(1)) {
      for (const int k : steps(2)) shifts.push_back(period.cwiseProduct(Vec3(i, j, k)));
    }
  }
  return shifts;
}

}  // namespace packmesh
