// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The distance to a wall as used by relaxation.
#pragma once

#include <optional>

#include "packMesh/container/container.h"
#include "packMesh/field/sampled_distance.h"
#include "packMesh/relaxation/body.h"
#include "packMesh/relaxation/wall_kernel.h"

namespace packmesh {

/// A wall in closed form, or sampled: on a fine grid for points that may touch it, on a coarse one to exclude
/// distant points and for cells that are deep in the wall.
class WallField {
 public:
  /// @param wall must outlive this
  /// @param region that contains all cells [µm]
  WallField(const Wall& wall, const Box& region);

  /// Distance at a point; exceeds the true one by at most slack() [µm].
  double distance(const Vec3& p) const;
  double slack() const { return slack_; }

  /// The wall in the frame of a cell that extends `reach` from its centre [µm].
  /// @param deep the cell is deep in the wall, so that coarse distances suffice
  WallFrame frameOf(const Body& body, double reach, bool deep) const;

 private:
  struct Sampled {
    const SampledDistance &coarse, &fine;
  };

  std::optional<ClosedFormWall> form_;
  std::optional<Sampled> sampled_;
  double slack_ = 0.0;
};

}  // namespace packmesh
