// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Inside of MeshHierarchy: a tree of discs over a mesh, four children to a node.
///
/// Everything here only culls: floats with margins, never a verdict. A disc is what a sphere and the slab
/// between two parallel planes have in common: patches of two membranes that nearly touch are told apart by
/// thin discs long before boxes of any fixed orientation do, and two discs cost a third of what two oriented
/// boxes do.
#pragma once

#include <array>
#include <vector>

#include "packMesh/mesh/convex_hull.h"
#include "packMesh/mesh/hierarchy_kernel.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

struct MeshTree {
  TriangleMesh mesh;

  std::vector<DiscQuad> quads;                ///< the first has one lane, which holds everything
  std::vector<std::array<float, 9>> corners;  ///< of each triangle, corner by corner
  std::vector<int> discs;                     ///< where the disc of each triangle is (DiscQuad::disc)
  ConvexHull hull;

  Vec3 center;               ///< of a sphere around all vertices [µm]
  double radius;             ///< of that sphere
  double reach;              ///< largest distance of a vertex from the origin of the body frame [µm]
  double volume;             ///< enclosed [µm³], >= 0
  Vec3 centroid;             ///< of the enclosed volume
  std::vector<int> samples;  ///< one vertex of each connected component

  explicit MeshTree(const TriangleMesh& mesh);
};

/// Where a linear map takes unit vectors: bounds of its singular values (Gershgorin's circles of the Gram
/// matrix: sharp for a scaled rotation, safe for everything).
double largestStretch(const Mat3& linear);

}  // namespace packmesh
