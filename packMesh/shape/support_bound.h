// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A convex body around a shape, with a support function that is cheap to evaluate.
#pragma once

#include <cmath>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Minkowski sum of a disc (radius `ring`, in the body's x-z plane) and an axis-aligned ellipsoid: exact for
/// ellipsoids, within 1 % for red cells, valid for every shape.
struct SupportBound {
  double ring = 0.0;             ///< radius of the disc [µm]
  Vec3 semiAxes = Vec3::Ones();  ///< [µm]

  /// Largest n·x over the body, for a unit vector n in the body frame [µm].
  double support(const Vec3& n) const {
    return ring * std::sqrt(n.x() * n.x() + n.z() * n.z()) + semiAxes.cwiseProduct(n).norm();
  }
};

/// The tightest bound of this kind found for the vertices of `mesh`. Post: contains every vertex.
/// @param rings number of radii of the disc that are tried
SupportBound boundSupport(const TriangleMesh& mesh, int rings = 40);

}  // namespace packmesh
