// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How deep a point lies below the wall that blood flows along.
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "packMesh/container/side_wall.h"
#include "packMesh/field/sampled_distance.h"

namespace packmesh {

/// Distances to a side wall: exact if it has a closed form, otherwise interpolated between exact ones at
/// nodes at least a micrometre apart, of which there are at most about 300,000. Threads can share it.
class SideDepth {
 public:
  /// @param bounds of the lumen [µm]
  SideDepth(std::shared_ptr<const SideWall> wall, const Box& bounds);

  /// Positive inside the lumen [µm]; the gradient points away from the wall.
  DistanceSample operator()(const Vec3& p) const {
    return sampled_ ? sampled_->sample(p) : wall_->distance(p);
  }

  const std::shared_ptr<const SideWall>& wall() const { return wall_; }
  const Box& bounds() const { return bounds_; }

 private:
  /// Wall::sample() may give less than the distance deep inside.
  struct Exactly final : DistanceSource {
    std::shared_ptr<const SideWall> wall;
    explicit Exactly(std::shared_ptr<const SideWall> of) : wall(std::move(of)) {}
    void sample(const NodeBlock& block, float* distances) const override {
      wall->Wall::sample(block, distances);
    }
  };

  std::shared_ptr<const SideWall> wall_;
  Box bounds_;
  Exactly exactly_;
  std::optional<SampledDistance> sampled_;
};

}  // namespace packmesh
