// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The wall that blood flows along, how deep a point lies below it, and the part of a lumen at certain
/// depths.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <utility>

#include "packMesh/container/container.h"
#include "packMesh/container/region.h"
#include "packMesh/field/sampled_distance.h"

namespace packmesh {

/// The wall of a lumen without the planes that close it at its ends (Wall::distanceToSides()).
class SideWall final : public Wall {
 public:
  /// @param ends axes along which the lumen ends other than at a wall
  /// Pre: the lumen has a wall
  SideWall(std::shared_ptr<const Container> lumen, const std::array<bool, 3>& ends);

  /// Whether anything is left of the wall.
  bool exists() const { return !form_ || form_->exists(); }

  WallDistance distance(const Vec3& p) const override {
    return form_ ? form_->distance(p) : wall().distanceToSides(p, ends_);
  }
  double slack() const override { return wall().slack(); }
  std::optional<ClosedFormWall> closedForm() const override { return form_; }
  double samplingSpacing() const override { return wall().samplingSpacing(); }
  /// As the wall of the lumen samples them, except where an end is nearer.
  void sample(const NodeBlock& block, float* distances) const override;
  /// As the wall of the lumen, ends included.
  WallVerdict examine(const PlacedHierarchy& cell, double largestGap) const override {
    return wall().examine(cell, largestGap);
  }

 private:
  const Wall& wall() const { return *lumen_->wall(); }

  std::shared_ptr<const Container> lumen_;
  std::array<bool, 3> ends_;
  Box bounds_;
  std::optional<ClosedFormWall> form_;
};

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
