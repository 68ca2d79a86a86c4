// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Signed distances to a surface at many points at once.
#pragma once

#include <array>
#include <vector>

#include "packMesh/geometry/closest_point.h"

namespace packmesh {

/// Signed distances (positive outside, µm) at the points (x[i], y[j], z[k]), `x` fastest, exact to rounding to
/// float. Neighbouring points share the search for the triangles that can be nearest; they should be nearer to
/// each other than to most of the surface. Pre: coordinates ascend (equal ones are allowed); the mesh of
/// `surface` is closed and oriented outwards.
/// @param rough points inside that are further from the surface than several times from their neighbours are
///   only told to be so far inside at least: three fifths of what they are or more
void signedDistances(const ClosestPoint& surface, const std::array<std::vector<double>, 3>& coordinates,
                     bool rough, float* distances);

}  // namespace packmesh
