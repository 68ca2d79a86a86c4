// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The part of a lumen at certain depths below its wall.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>

#include "packMesh/container/region.h"
#include "packMesh/container/side_depth.h"

namespace packmesh {

/// Where the depth is between two values, one of which can be infinite.
class DepthShell final : public Region {
 public:
  /// @param from, to [µm]
  DepthShell(std::shared_ptr<const SideDepth> depth, double from, double to)
      : depth_(std::move(depth)), from_(from), to_(to) {}

  WallDistance distance(const Vec3& p) const override {
    const DistanceSample depth = (*depth_)(p);
    const double above = depth.distance - from_, below = to_ - depth.distance;
    if (above < below) return {above, depth.gradient};
    return {below, -depth.gradient};
  }
  const Box& bounds() const override { return depth_->bounds(); }

 private:
  std::shared_ptr<const SideDepth> depth_;
  double from_, to_;
};

}  // namespace packmesh
