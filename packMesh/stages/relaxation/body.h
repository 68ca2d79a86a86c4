// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A cell while it is being moved.
#pragma once

#include <cstdint>

#include "packMesh/geometry/pose.h"
#include "packMesh/stages/relaxation/contact_kernel.h"

namespace packmesh {

struct Body {
  Vec3 position = Vec3::Zero();  ///< [µm]
  Quaternion orientation = Quaternion::Identity();
  Mat3 rotation = Mat3::Identity();  ///< of `orientation`
  double scale = 1.0;
  int species = 0;
  int block = 0;
  std::int64_t id = 0;  ///< global, over all species

  /// Where the cell was at the beginning of the epoch: what is found out about its surroundings holds for as
  /// far as it has not moved from there.
  Vec3 referencePosition = Vec3::Zero();
  Quaternion referenceOrientation = Quaternion::Identity();
  double moved = 0.0;  ///< no point of the cell is further than this from where it was then [µm]
  /// The wall need not be looked at while `moved` is less than this.
  double awayFromWallWhile = -1.0;
  /// While `moved` is less than wallMaskWhile, only these clusters of samples can touch the wall.
  ClusterMask wallMask = allClusters;
  double wallMaskWhile = -1.0;
  bool deepInWall = true;           ///< was deep in the wall when last looked at, so coarse samples will do
  double overlap = 0.0;             ///< sum of its penetrations in the last sweep [µm]
  bool changed = false;             ///< moved since other ranks were told
  bool touched = false;             ///< moved since Relaxation::forgetTouched()
  double extraWallClearance = 0.0;  ///< given to cells that the exact test found misplaced [µm]

  /// Begins an epoch: here and now is the reference.
  void setReference() {
    referencePosition = position;
    referenceOrientation = orientation;
    moved = 0.0;
    awayFromWallWhile = wallMaskWhile = -1.0;
  }

  Pose pose() const { return {scale, orientation, position}; }
};

}  // namespace packmesh
