// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Separation test of convex hulls.
#pragma once

#include "packMesh/mesh/convex_hull.h"

namespace packmesh {

/// Tries to prove that `first` and `second`, mapped into the frame of `first` by x -> linear·x + translation,
/// are more than `distance` apart. false: they are not, or the test was inconclusive.
///
/// Method: E. Gilbert, D. Johnson, S. Keerthi, "A fast procedure for computing the distance between complex
/// objects in three-dimensional space", IEEE J. Robotics Automation 4 (1988). Every direction tried gives a
/// valid lower bound of the distance, so no step needs to be exact.
/// @param direction initial direction, from the second to the first; not zero
/// @param rounding upper bound of the rounding error of distances in the frame of `first` (coordinates and
/// supports)
bool hullsApart(const ConvexHull& first, const ConvexHull& second, const Mat3& linear,
                const Vec3& translation, const Vec3& direction, double distance, double rounding);

}  // namespace packmesh
