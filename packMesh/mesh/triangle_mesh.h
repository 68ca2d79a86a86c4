// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Triangle meshes, the reference geometry of cells and vessels.
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

/// One side of an edge: the edge of a triangle between its corners k and k+1.
struct TriangleSide {
  int lo, hi;  ///< the two vertices of the edge
  int triangle;
  bool forwards;  ///< the triangle traverses the edge from lo to hi
  bool sameEdge(const TriangleSide& other) const { return lo == other.lo && hi == other.hi; }
};

/// Sides of all triangles, sorted by edge and, within an edge, by triangle.
std::vector<TriangleSide> sortedSides(const TriangleMesh& mesh);

/// Enclosed volume [µm³] by the divergence theorem; negative if the mesh is inverted. Pre: closed.
double signedVolume(const TriangleMesh& mesh);

/// Surface area [µm²].
double surfaceArea(const TriangleMesh& mesh);

/// Points on lines from the origin, farther from it by this factor.
std::vector<Vec3> scaledBy(double factor, std::vector<Vec3> points);

/// Bounding box of all vertices [µm].
Box boundingBox(const TriangleMesh& mesh);

/// The mesh (or only its vertices) with every vertex mapped by `placement`.
TriangleMesh placed(const TriangleMesh& mesh, const Placement& placement);
std::vector<Vec3> placedVertices(const TriangleMesh& mesh, const Placement& placement);

/// Reverses the orientation of every triangle.
void flip(TriangleMesh& mesh);

}  // namespace packmesh
