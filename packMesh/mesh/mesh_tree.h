// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Implementation of MeshHierarchy: a tree of discs over a mesh, four children per node.
///
/// Used only for culling: floats with margins, never a decision. A disc is the intersection of a sphere and
/// the slab between two parallel planes. Thin discs separate patches of two membranes that nearly touch much
/// earlier than boxes of any fixed orientation, and a test of two discs costs a third of one of two oriented
/// boxes.
#pragma once

#include <array>
#include <vector>

#include "packMesh/mesh/convex_hull.h"
#include "packMesh/mesh/hierarchy_kernel.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

struct MeshTree {
  TriangleMesh mesh;

  std::vector<DiscQuad> quads;                 ///< the first has one lane, which contains the whole mesh
  std::vector<std::array<float, 3>> vertices;  ///< of the mesh [µm]
  std::vector<int> discs;                      ///< position of each triangle's disc (DiscQuad::disc)
  ConvexHull hull;                             ///< empty for a deformed mesh

  Vec3 center;    ///< centre of a sphere around all vertices [µm]
  double radius;  ///< radius of that sphere [µm]
  Mat3 spread;    ///< mean of (v - center)(v - center)ᵀ over the hull's vertices, not singular [µm²]
  double reach;   ///< largest distance of a vertex from the origin of the body frame [µm]
  double volume;  ///< enclosed volume [µm³], >= 0
  Vec3 centroid;  ///< centroid of the enclosed volume [µm]
  std::vector<int> samples;  ///< one vertex of each connected component

  explicit MeshTree(const TriangleMesh& mesh);
  /// Of a deformed form of the mesh of another tree, of which it takes the patches: in a tenth of the time,
  /// with looser discs.
  /// @param positions of the vertices in the order of the other mesh [µm]
  MeshTree(std::vector<Vec3> positions, const MeshTree& undeformed);

 private:
  void measure();
};

/// Upper bound of the singular values of a linear map (Gershgorin circles of the Gram matrix: sharp for a
/// scaled rotation, valid for every map).
double largestStretch(const Mat3& linear);

}  // namespace packmesh
