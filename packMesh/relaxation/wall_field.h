// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A wall as relaxation asks for it.
#pragma once

#include <optional>

#include "packMesh/container/container.h"
#include "packMesh/field/sampled_distance.h"
#include "packMesh/relaxation/body.h"
#include "packMesh/relaxation/wall_kernel.h"

namespace packmesh {

/// A wall in closed form, or sampled: finely for points that may touch it, coarsely for what is only to be
/// told to be far away, and for cells that are deep in it.
class WallField {
 public:
  /// @param wall must outlive this
  /// @param region where cells can be [µm]
  WallField(const Wall& wall, const Box& region);

  /// Distance at a point; at most slack() more than the true one [µm].
  double distance(const Vec3& p) const;
  double slack() const { return slack_; }

  /// The wall as seen from a cell that reaches `reach` from its centre [µm].
  /// @param deep the cell is deep in the wall, so that coarse distances will do
  WallFrame frameOf(const Body& body, double reach, bool deep) const;

 private:
  struct Sampled {
    SampledDistance coarse, fine;
    Sampled(const Wall& wall, const Box& region, double spacing, double coarseSpacing)
        : coarse(wall, region, coarseSpacing), fine(wall, region, spacing) {}
  };

  std::optional<ClosedFormWall> form_;
  std::optional<Sampled> sampled_;
  double slack_ = 0.0;
};

}  // namespace packmesh
