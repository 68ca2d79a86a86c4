// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A signed distance sampled on a sparse grid.
#pragma once

#include <cstdint>

#include "packMesh/core/box.h"
#include "packMesh/field/bricks.h"
#include "packMesh/field/distance_source.h"

namespace packmesh {

/// Interpolates a distance between nodes at integer multiples of a spacing, in bricks that are computed when
/// they are first needed: time and memory depend on the wall's area near cells, not on the lumen's volume.
/// The result does not depend on the order of evaluations. Threads can share it.
class SampledDistance {
 public:
  /// @param source must outlive this
  /// @param region expected range of points; outside of it, the result is the distance at the nearest point
  ///   of the region minus the distance to that point
  /// @param spacing of the nodes [µm]
  /// @throws InputError if the region has more than 2^28 bricks of nodes
  SampledDistance(const DistanceSource& source, const Box& region, double spacing);

  SampledDistance(const SampledDistance&) = delete;
  SampledDistance& operator=(const SampledDistance&) = delete;

  DistanceSample sample(const Vec3& p) const;

  double spacing() const { return spacing_; }
  /// Grid coordinates: bricks begin at integer multiples of BrickView::cells.
  Vec3 nodeOf(const Vec3& p) const { return p / spacing_ - lo_; }
  BrickView view() const;

 private:
  const std::int16_t* brick(int index) const;

  const DistanceSource& source_;
  double spacing_;
  Vec3 lo_;  ///< node of the first brick
  mutable Bricks<std::int16_t, std::int32_t> bricks_;
};

}  // namespace packmesh
