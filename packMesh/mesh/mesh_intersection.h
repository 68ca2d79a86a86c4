// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Exact tests between placed meshes.
#pragma once

#include <limits>

#include "packMesh/core/box.h"
#include "packMesh/mesh/mesh_tree.h"

namespace packmesh {

/// Relative position of two placed closed meshes.
enum class MeshRelation {
  apart,         ///< no common point, neither inside the other
  meet,          ///< some triangle of one meets some triangle of the other, even in a single point
  firstInside,   ///< the first lies entirely inside the second
  secondInside,  ///< the second lies entirely inside the first
};

struct MeshPairResult {
  MeshRelation relation = MeshRelation::apart;
  /// Distance between the two surfaces [µm] if they are apart by less than `gapOfInterest`, infinity if by
  /// more; 0 otherwise.
  double gap = std::numeric_limits<double>::infinity();
};

/// Determines exactly (Shewchuk's adaptive predicates on the world vertices `placement(v)`) the relative
/// position of two meshes.
/// @param gapOfInterest only gaps below this are measured [µm]; 0: none
/// Pre: both meshes closed and consistently oriented, templates not self-intersecting; placements invertible
/// (any scale).
MeshPairResult relate(const MeshHierarchy& first, const Placement& firstPlacement,
                      const MeshHierarchy& second, const Placement& secondPlacement,
                      double gapOfInterest = 0.0);

/// Distance between two surfaces [µm] if it is below `gapOfInterest`, 0 if they meet (exact), otherwise
/// infinity. Surfaces can be open; whether one lies inside the other is not tested.
double surfaceGap(const MeshHierarchy& first, const Placement& firstPlacement, const MeshHierarchy& second,
                  const Placement& secondPlacement, double gapOfInterest);

/// A sphere that contains every world vertex of a placed mesh.
Sphere boundingSphere(const MeshHierarchy& mesh, const Placement& placement);
/// The same of a mesh that has this sphere around its vertices in its body frame.
Sphere boundingSphere(const Sphere& ofBody, const Placement& placement);

/// True if `p` lies inside the closed mesh placed by `placement`: the surface winds around it, once or more
/// often. Exact; points on the surface count as inside.
bool isInside(const Vec3& p, const MeshHierarchy& mesh, const Placement& placement);

}  // namespace packmesh
