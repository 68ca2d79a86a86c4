// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Camera and lights of scenes for POV-Ray. Internal to packMesh/io.
#pragma once

#include <vector>

#include "packMesh/io/pov_text.h"

namespace packmesh::pov {

/// What the camera must see.
struct Extent {
  Vec3 center;
  double radius;
};

/// Camera and lights. The camera sees every extent at any aspect ratio, from where the declared Azimuth and
/// Elevation [degrees] say; Turn turns it further about the vertical, and then all turns show everything from
/// the same distance. Declares ToCamera and ClipSide's default, see writePovScene().
/// @param size of the box around all [µm]
/// @param fine whether shadows are soft unless somebody says otherwise
void writeCamera(SceneFile& out, const std::vector<Extent>& extents, const Vec3& size, bool fine);

}  // namespace packmesh::pov
