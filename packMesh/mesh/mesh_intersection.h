// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Exact tests between placed meshes.
#pragma once

#include <limits>

#include "packMesh/core/sphere.h"
#include "packMesh/mesh/mesh_hierarchy.h"

namespace packmesh {

/// How two placed closed meshes lie to each other.
enum class MeshRelation {
  apart,         ///< no common point, neither inside the other
  meet,          ///< some triangle of one meets some triangle of the other, even in a single point
  firstInside,   ///< the first lies wholly inside the second
  secondInside,  ///< the second lies wholly inside the first
};

struct MeshPairResult {
  MeshRelation relation = MeshRelation::apart;
  /// Distance between the two surfaces [µm] when they are apart and it is below `gapOfInterest`, infinity
  /// when it is not below; 0 otherwise.
  double gap = std::numeric_limits<double>::infinity();
};

/// Decides exactly (Shewchuk's adaptive predicates on the world vertices `placement(v)`) how two meshes lie.
/// @param gapOfInterest only gaps below this are measured [µm]; 0: none
/// Pre: both meshes closed, not self-intersecting, consistently oriented; placements invertible (any scale).
MeshPairResult relate(const MeshHierarchy& first, const Placement& firstPlacement,
                      const MeshHierarchy& second, const Placement& secondPlacement,
                      double gapOfInterest = 0.0);

/// Distance between two surfaces [µm] when it is below `gapOfInterest`, 0 when they meet (exact), else
/// infinity. Surfaces may be open; that one may lie inside the other is not looked at.
double surfaceGap(const MeshHierarchy& first, const Placement& firstPlacement, const MeshHierarchy& second,
                  const Placement& secondPlacement, double gapOfInterest);

/// A sphere that holds every world vertex of a placed mesh.
Sphere boundingSphere(const MeshHierarchy& mesh, const Placement& placement);

/// Whether `p` lies inside the closed mesh placed by `placement` (exact; a point on the surface counts as
/// inside).
bool isInside(const Vec3& p, const MeshHierarchy& mesh, const Placement& placement);

}  // namespace packmesh
