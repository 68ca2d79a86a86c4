// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A signed distance remembered on a sparse grid.
#pragma once

#include <cstdint>

#include "packMesh/core/box.h"
#include "packMesh/field/bricks.h"
#include "packMesh/field/distance_source.h"

namespace packmesh {

/// Interpolates a distance between nodes at whole multiples of a spacing, in bricks that are filled when they
/// are first needed: time and memory go with the wall's area near cells, not with the lumen's volume. The
/// result does not depend on the order of questions.
///
/// For one thread at a time.
class SampledDistance {
 public:
  /// @param source must outlive this
  /// @param region where questions are expected; outside of it the distance is taken to be that at the
  ///   nearest point of the region, less the way there
  /// @param spacing of the nodes [µm]
  /// @throws InputError when the region has more than 2^28 bricks of nodes
  SampledDistance(const DistanceSource& source, const Box& region, double spacing);

  SampledDistance(const SampledDistance&) = delete;
  SampledDistance& operator=(const SampledDistance&) = delete;

  DistanceSample sample(const Vec3& p) const;

  double spacing() const { return spacing_; }
  /// Coordinates in the grid: bricks begin at whole multiples of BrickView::cells.
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
