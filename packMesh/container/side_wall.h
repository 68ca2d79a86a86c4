// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The wall that blood flows along.
#pragma once

#include <array>
#include <memory>

#include "packMesh/container/container.h"

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

}  // namespace packmesh
