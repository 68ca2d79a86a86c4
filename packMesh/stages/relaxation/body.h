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

  /// No point of the cell has moved further than this since the start [µm]; only ever grows.
  double travel = 0.0;
  /// The wall need not be looked at before `travel` reaches this.
  double awayFromWallUntil = 0.0;
  /// The clusters of samples that can touch the wall before `travel` reaches this.
  ClusterMask wallMask = allClusters;
  double wallMaskUntil = 0.0;
  double lastWallTravel = 0.0;      ///< travel when the wall was looked at last [µm]
  bool deepInWall = true;           ///< was deep in the wall then, so coarse samples will do
  double overlap = 0.0;             ///< sum of its penetrations in the last sweep [µm]
  double extraWallClearance = 0.0;  ///< given to cells that the exact test found misplaced [µm]

  Pose pose() const { return {scale, orientation, position}; }
};

}  // namespace packmesh
