// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Camera and lights of scenes for POV-Ray. Internal to packMesh/io.
#pragma once

#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/io/pov_text.h"

namespace packmesh::pov {

/// What the camera must see.
struct Extent {
  Vec3 center;
  double radius;
};

/// Camera and lights. The camera sees every extent at any aspect ratio, from where the declared Azimuth and
/// Elevation [degrees] say; Turn turns it further about the vertical, and then all turns show everything from
/// the same distance. Declares ToCamera.
/// @param size of the box around all [µm]
/// @param clipped box that the plane of ClipAxis and ClipAt cuts, see writePovScene(): then what is in front
/// of
///   the plane needs no room. Declares ClipNormal and ClipOffset. nullptr: nothing is cut
void writeCamera(SceneFile& out, const std::vector<Extent>& extents, const Vec3& size, const Box* clipped);

}  // namespace packmesh::pov
