// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Where a cell is: the state that packing changes (Pose) and the map that is handed over (Placement).
#pragma once

#include "packMesh/core/vector.h"

namespace packmesh {

/// Affine map from a template's body frame to the world: x -> linear * x + translation [µm].
///
/// Every final statement (certificate, acceptance) is about meshes placed by a Placement, so that it can be
/// made from exactly the numbers that are written to a file.
struct Placement {
  Mat3 linear = Mat3::Identity();
  Vec3 translation = Vec3::Zero();

  /// The one formula by which template vertices become world vertices.
  Vec3 operator()(const Vec3& body) const { return linear * body + translation; }
};

/// State of one cell (thesis eq. 3.5): scale [fraction of full size], orientation, position of the template's
/// origin [µm].
struct Pose {
  double scale = 1.0;
  Quaternion orientation = Quaternion::Identity();
  Vec3 position = Vec3::Zero();

  Placement placement() const { return {scale * orientation.toRotationMatrix(), position}; }
};

}  // namespace packmesh
