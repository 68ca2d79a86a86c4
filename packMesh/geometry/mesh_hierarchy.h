// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Inside of MeshHierarchy: a tree of oriented boxes over a mesh, four children and four triangles at a
/// time.
///
/// Everything here only culls: floats with margins, never a verdict. Oriented boxes (S. Gottschalk, M. Lin,
/// D. Manocha, "OBBTree", SIGGRAPH 1996), because patches of two membranes that nearly touch are told apart
/// by thin boxes long before boxes of any fixed orientation do.
#pragma once

#include <vector>

#include "packMesh/geometry/convex_hull.h"
#include "packMesh/geometry/float4.h"
#include "packMesh/geometry/triangle_mesh.h"

namespace packmesh {

/// One oriented box; rows of `axis` are its unit axes [body frame, µm].
struct OrientedBox {
  float center[3], axis[3][3], half[3];
};

/// Up to four oriented boxes, lane by lane; unused lanes are infinitely far from everything.
struct BoxQuad {
  Float4 center[3], axis[3][3], half[3];
  int box[4];  ///< index into MeshTree::boxes, -1: unused lane
};

/// Up to four triangles; unused lanes repeat the last one.
struct TriangleQuad {
  Float4 corner[3][3];       ///< [corner][coordinate]
  Float4 normal[3];          ///< unit
  Float4 lo, hi;             ///< extent along the normal
  Float4 center[3], radius;  ///< a sphere around it
  int triangle[4];
  int count;
};

/// A box of the tree with what it holds: content >= 0: quads[content], else leaves[~content].
struct TreeBox {
  OrientedBox box;
  float size;  ///< half diagonal [µm]
  int content;
};

struct MeshTree {
  TriangleMesh mesh;

  std::vector<TreeBox> boxes;  ///< boxes[0] holds everything
  std::vector<BoxQuad> quads;
  std::vector<TriangleQuad> leaves;
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
