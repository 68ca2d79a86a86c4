// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Winding number of a closed surface around a point.
#pragma once

#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Solid angle [sr] subtended by `triangles` at `p`, after Van Oosterom and Strackee, IEEE Trans. Biomed.
/// Eng. 30, 1983: 4π for p inside a closed surface that is oriented outwards, 0 outside, -4π inside one that
/// is oriented inwards. Not exact near the surface; linear cost.
double solidAngle(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles, const Vec3& p);

}  // namespace packmesh
