// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The part of a lumen beyond a cut.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "packMesh/container/region.h"
#include "packMesh/parallel/threads.h"

namespace packmesh {

/// The part of a lumen beyond a cut, that is, a plane section of the lumen through a point: only the section
/// around that point, not others in the same plane. All that is connected with its far side is beyond it. The
/// ends of periods bound it, too.
///
/// Which points are beyond it is found by flooding an AccessibleSpace once. Within the lumen only the section
/// bounds the region, so distances are those to a disc around the section, with the sign of the side.
class LumenCut final : public Region {
 public:
  /// Does not refer to the container later.
  /// @param direction into the region, of any length but 0
  /// @throws InputError if the point is not in the lumen, if the lumen has no wall or is too large, or if its
  ///   two sides are connected elsewhere
  LumenCut(const Container& lumen, const Vec3& point, const Vec3& direction, const Threads& threads);

  WallDistance distance(const Vec3& p) const override;
  const Box& bounds() const override { return bounds_; }

 private:
  /// Of points; cut: those near the section, which are beyond it if they are on the far side of its plane.
  enum class Side : std::uint8_t { before, beyond, cut };
  /// The boxes of a size in which the lumen has points: their sides by place in a grid.
  struct Level {
    Vec3 edge;  ///< [µm]
    std::unordered_map<std::int64_t, Side> sides;
  };

  Side sideAt(const Vec3& p) const;

  Box lumen_, bounds_;
  Vec3 period_, point_, normal_;
  double radius_ = 0.0;        ///< of the disc [µm]
  std::vector<Level> levels_;  ///< ascending in size; the last is one box around everything
  /// Whether the region ends at the low and at the high end of the period, and goes on beyond neither.
  std::array<std::array<bool, 2>, 3> ends_ = {};
};

}  // namespace packmesh
