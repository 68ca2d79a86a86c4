// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A body as it travels between ranks and rests in files.
#pragma once

#include <cstdint>

#include "packMesh/relaxation/body.h"

namespace packmesh {

/// Where a body is; trivially copyable.
struct PlainPose {
  double position[3];     ///< [µm]
  double orientation[4];  ///< x, y, z, w

  static PlainPose of(const Body& body);
  /// Puts the body there.
  void giveTo(Body& body) const;
};

/// All of a body that lasts from one list of pairs to the next; trivially copyable.
struct BodyState {
  PlainPose pose;
  double scale, extraWallClearance, overlap, moved, stepTaken;
  std::int64_t id;
  std::int32_t species, block;
  bool deepInWall, touched, frozen;
};

BodyState stateOf(const Body& body);
Body bodyOf(const BodyState& state);

}  // namespace packmesh
