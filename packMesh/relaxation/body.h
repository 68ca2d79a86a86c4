// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A cell while it is being moved.
#pragma once

#include <cstdint>

#include "packMesh/core/pose.h"
#include "packMesh/relaxation/contact_kernel.h"

namespace packmesh {

/// Aligned so that threads that move neighbours in memory do not write to the same lines of their caches.
struct alignas(64) Body {
  Vec3 position = Vec3::Zero();  ///< [µm]
  Quaternion orientation = Quaternion::Identity();
  Mat3 rotation = Mat3::Identity();  ///< of `orientation`
  double scale = 1.0;
  int species = 0;
  int block = 0;
  std::int64_t id = 0;  ///< global, over all species

  /// Upper bound of the displacement of any of its points since the pairs were last listed [µm]. Results
  /// about its surroundings stay valid up to a certain displacement.
  double moved = 0.0;
  double awayFromWallUntil = -1.0;  ///< the wall test is skipped until `moved` reaches this
  /// Until `moved` reaches wallMaskUntil, only these clusters of samples can touch the wall.
  ClusterMask wallMask = allClusters;
  double wallMaskUntil = -1.0;
  bool deepInWall = true;           ///< was deep in the wall at the last test, so coarse samples suffice
  bool sleeping = false;            ///< until it moves, the tests against wall and region are skipped
  double overlap = 0.0;             ///< sum of its penetrations in the last sweep [µm]
  bool changed = false;             ///< moved since the last ghost update
  bool touched = false;             ///< moved since Relaxation::forgetTouched()
  double extraWallClearance = 0.0;  ///< added for cells that the exact test found misplaced [µm]
  double stepTaken = 1.0;           ///< growth: the fraction of the last proposed step that was taken
  bool frozen = false;              ///< growth: does not move, and neighbours grow up to its surface

  /// Discards everything cached about its surroundings.
  void forgetSurroundings() {
    moved = 0.0;
    awayFromWallUntil = wallMaskUntil = -1.0;
  }

  Pose pose() const { return {scale, orientation, position}; }
  void setPose(const Pose& pose) {
    scale = pose.scale;
    position = pose.position;
    orientation = pose.orientation;
    rotation = orientation.toRotationMatrix();
  }
};

/// A body with the given pose.
inline Body makeBody(std::int64_t id, int species, const Pose& pose) {
  Body body;
  body.id = id;
  body.species = species;
  body.setPose(pose);
  return body;
}

}  // namespace packmesh
