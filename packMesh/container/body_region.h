// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Parts of a lumen that bodies bound.
#pragma once

#include <memory>
#include <vector>

#include "packMesh/container/region.h"

namespace packmesh {

/// The part of a lumen inside one body and outside others; bodies repeat along the lumen's periodic axes.
class BodyRegion final : public Region {
 public:
  /// @param inside nullptr: everything
  /// @param outside bodies that are not part of the region
  /// @param bounds, period of the lumen [µm]
  BodyRegion(std::shared_ptr<const Container> inside, std::vector<std::shared_ptr<const Container>> outside,
             const Box& bounds, const Vec3& period);

  WallDistance distance(const Vec3& p) const override;
  const Box& bounds() const override { return bounds_; }

 private:
  WallDistance ofBody(const Container& body, const Vec3& p) const;

  std::shared_ptr<const Container> inside_;
  std::vector<std::shared_ptr<const Container>> outside_;
  std::vector<Vec3> shifts_;  ///< translations to the periodic images
  Box bounds_;
};

/// Volume of the part of the region in the lumen [µm³], continued ends of a vessel included: cubes crossed by
/// either surface are halved, to an accuracy of about 1e-4 of the lumen (4e-4 without a closed form).
double volumeInLumen(const Region& region, const Container& lumen);

}  // namespace packmesh
