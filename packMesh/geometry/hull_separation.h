// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Are the convex hulls of two meshes a distance apart?
#pragma once

#include "packMesh/geometry/mesh_hierarchy.h"

namespace packmesh {

/// Tries to prove that the convex hulls of `first` and of `second`, mapped into the frame of `first` by
/// x -> linear·x + translation, are more than `distance` apart. false: they are not, or it could not be told.
///
/// Method: E. Gilbert, D. Johnson, S. Keerthi, "A fast procedure for computing the distance between complex
/// objects in three-dimensional space", IEEE J. Robotics Automation 4 (1988). Every direction it comes
/// through yields a lower bound of the distance that is valid by itself, so no step needs to be exact.
/// @param distance in the frame of `first`, must exceed the rounding error `rounding` of supports in floats
bool hullsApart(const MeshTree& first, const MeshTree& second, const Mat3& linear, const Vec3& translation,
                double distance, double rounding);

/// The vertex furthest along `direction`, and how far, up to rounding to float.
struct Support {
  int vertex;
  float value;
};
Support furthest(const MeshTree& tree, const Vec3& direction);

}  // namespace packmesh
