// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Triangle meshes: the truth about every cell and vessel.
#pragma once

#include <array>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/core/pose.h"

namespace packmesh {

using Triangle = std::array<int, 3>;

/// Indexed triangle mesh, vertices in µm, triangles counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;

  const Vec3& corner(int triangle, int k) const { return vertices[triangles[triangle][k]]; }
};

/// One side of an edge: a triangle has it between its corners k and k+1.
struct TriangleSide {
  int lo, hi;  ///< the two vertices of the edge
  int triangle;
  bool forwards;  ///< the triangle runs from lo to hi
  bool sameEdge(const TriangleSide& other) const { return lo == other.lo && hi == other.hi; }
};

/// Those of all triangles, edge after edge, at each in the order of the triangles.
std::vector<TriangleSide> sortedSides(const TriangleMesh& mesh);

/// Enclosed volume [µm³] by the divergence theorem; negative when the mesh is inside out. Pre: closed.
double signedVolume(const TriangleMesh& mesh);

/// Surface area [µm²].
double surfaceArea(const TriangleMesh& mesh);

/// Bounding box of all vertices [µm].
Box boundingBox(const TriangleMesh& mesh);

/// The mesh, or its vertices alone, with every vertex mapped by `placement`.
TriangleMesh placed(const TriangleMesh& mesh, const Placement& placement);
std::vector<Vec3> placedVertices(const TriangleMesh& mesh, const Placement& placement);

/// The mesh with the orientation of every triangle turned round.
void flip(TriangleMesh& mesh);

}  // namespace packmesh
