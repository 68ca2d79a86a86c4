// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Spheres.
#pragma once

#include "packMesh/core/vector.h"

namespace packmesh {

struct Sphere {
  Vec3 center;
  double radius;
};

}  // namespace packmesh
