// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Parts of a lumen that bodies and planes bound.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "packMesh/container/region.h"

namespace packmesh {

/// The part of a lumen inside a body, which repeats along the lumen's periodic axes.
class BodyRegion final : public Region {
 public:
  /// @param bounds, period of the lumen [µm]
  BodyRegion(std::shared_ptr<const Container> body, const Box& bounds, const Vec3& period);

  WallDistance distance(const Vec3& p) const override;
  const Box& bounds() const override { return bounds_; }

 private:
  std::shared_ptr<const Container> body_;
  std::vector<Vec3> shifts_;  ///< translations to the periodic images
  Box bounds_;
};

/// The part of a lumen beyond a plane; along a periodic axis that the plane cuts, as far as the period ends.
class HalfSpace final : public Region {
 public:
  /// @param normal unit vector, into the region
  /// @param bounds, period of the lumen [µm]
  HalfSpace(const Vec3& point, const Vec3& normal, const Box& bounds, const Vec3& period);

  WallDistance distance(const Vec3& p) const override;
  const Box& bounds() const override { return bounds_; }

 private:
  Vec3 point_, normal_;
  std::vector<Vec3> shifts_;
  std::vector<int> ends_;  ///< periodic axes that the plane cuts
  Box lumen_, bounds_;
};

/// The part of a lumen inside one region and outside others.
class RegionDifference final : public Region {
 public:
  /// @param inside nullptr: everything
  /// @param bounds of the lumen [µm]
  RegionDifference(std::shared_ptr<const Region> inside, std::vector<std::shared_ptr<const Region>> outside,
                   const Box& bounds)
      : inside_(std::move(inside)),
        outside_(std::move(outside)),
        bounds_(inside_ ? inside_->bounds() : bounds) {}

  WallDistance distance(const Vec3& p) const override;
  const Box& bounds() const override { return bounds_; }

 private:
  std::shared_ptr<const Region> inside_;
  std::vector<std::shared_ptr<const Region>> outside_;
  Box bounds_;
};

/// Volume of the part of the region in the lumen [µm³], continued ends of a vessel included: cubes crossed by
/// either surface are halved, to an accuracy of about 1e-4 of the lumen (4e-4 without a closed form).
double volumeInLumen(const Region& region, const Container& lumen);

}  // namespace packmesh
