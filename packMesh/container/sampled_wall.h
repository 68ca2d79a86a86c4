// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A wall remembered on a grid.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/container/brick_view.h"
#include "packMesh/container/container.h"

namespace packmesh {

/// Interpolates a wall's distance between nodes at whole multiples of a spacing. Nodes are evaluated brick by
/// brick when they are first needed, so that time and memory go with the wall's area near cells, not with the
/// lumen's volume. What it tells does not depend on the order of questions.
///
/// For one thread at a time.
class SampledWall {
 public:
  /// @param wall must outlive this
  /// @param region where questions are expected; outside of it the wall is taken to be as far as at the
  ///   nearest point of the region, less the way there
  /// @param spacing of the nodes [µm]
  /// @throws InputError when the region has more than 2^28 bricks of nodes
  SampledWall(const Wall& wall, const Box& region, double spacing);

  SampledWall(const SampledWall&) = delete;
  SampledWall& operator=(const SampledWall&) = delete;

  WallDistance distance(const Vec3& p) const;

  double spacing() const { return spacing_; }
  /// Coordinates in the grid: bricks begin at whole multiples of BrickView::cells.
  Vec3 nodeOf(const Vec3& p) const { return p / spacing_ - lo_; }
  BrickView view() const;

 private:
  void evaluate(int index) const;

  const Wall& wall_;
  double spacing_;
  Vec3 lo_;  ///< node of the first brick
  int bricks_[3];
  mutable std::vector<std::int32_t> begins_;  ///< see BrickView
  mutable std::vector<std::int16_t> values_;
  mutable const std::int16_t* where_ = nullptr;  ///< values_.data()
};

}  // namespace packmesh
