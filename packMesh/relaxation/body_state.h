// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A body in the form in which it is sent between ranks and stored in files.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/relaxation/body.h"

namespace packmesh {

/// Position and orientation of a body; trivially copyable.
struct PlainPose {
  double position[3];     ///< [µm]
  double orientation[4];  ///< x, y, z, w

  static PlainPose of(const Body& body);
  /// Applies the pose to the body.
  void giveTo(Body& body) const;
};

/// Everything about a body that persists between neighbour lists; trivially copyable.
struct BodyState {
  PlainPose pose;
  double scale, extraWallClearance, overlap, moved, stepTaken;
  std::int64_t id;
  std::int32_t species, block;
  bool deepInWall, touched, frozen;
};

BodyState stateOf(const Body& body);
Body bodyOf(const BodyState& state);

std::vector<BodyState> statesOf(const std::vector<Body>& bodies);
std::vector<Body> bodiesOf(const std::vector<BodyState>& states);

}  // namespace packmesh
