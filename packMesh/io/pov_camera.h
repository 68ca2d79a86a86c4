// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Camera and lights of POV-Ray scenes. Internal to packMesh/io.
#pragma once

#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/io/pov_text.h"

namespace packmesh::pov {

/// An object that the camera must show.
struct Extent {
  Vec3 center;
  double radius;
};

/// Camera and lights. The camera shows every extent at any aspect ratio, from the position given by the
/// declared Azimuth and Elevation [degrees]; Turn rotates it further about the vertical, and then the
/// distance is such that all turns show everything. Declares ToCamera.
/// @param size of the box around everything [µm]
/// @param clipped box cut by the plane of ClipAxis and ClipAt, see writePovScene(): the part in front of the
/// plane need not be shown. Declares ClipNormal and ClipOffset. nullptr: no cut
void writeCamera(SceneFile& out, const std::vector<Extent>& extents, const Vec3& size, const Box* clipped);

}  // namespace packmesh::pov
