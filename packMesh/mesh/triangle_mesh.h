// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Triangle meshes, the reference geometry of cells and vessels.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/core/pose.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/core/vector.h"

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

/// What is wrong with the coordinates of a vertex, beginning with a blank, to follow its name; empty:
/// nothing.
std::string coordinateFault(const Vec3& v);

/// Keeps the first of all vertices with equal coordinates, in order of first occurrence.
/// @return for each input vertex its index among those kept
std::vector<int> mergeEqualVertices(std::vector<Vec3>& vertices);

/// The same for the vertices of a mesh. @return number of vertices removed
std::size_t mergeEqualVertices(TriangleMesh& mesh);

/// For each vertex, the first vertex connected to it by a chain of steps shorter than `distance` [µm];
/// usually itself. At most about 1000 n pairs are compared: if the vertices are so crowded that this does not
/// suffice, some steps are overlooked.
std::vector<int> firstOfNearVertices(const std::vector<Vec3>& vertices, double distance);

/// Removes the vertices that no triangle uses; keeps the order of the others. @return number of vertices
/// removed
std::size_t removeUnusedVertices(TriangleMesh& mesh);

}  // namespace packmesh
