// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/triangle_mesh.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace packmesh {

std::vector<TriangleSide> sortedSides(const TriangleMesh& mesh) {
  std::vector<TriangleSide> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<int>(t), a < b});
    }
  std::sort(sides.begin(), sides.end(), [](const TriangleSide& a, const TriangleSide& b) {
    return std::tie(a.lo, a.hi, a.triangle) < std::tie(b.lo, b.hi, b.triangle);
  });
  return sides;
}

double signedVolume(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return 0.0;
  // Relative to a vertex of the mesh, so that distant meshes lose no digits.
  const Vec3 origin = mesh.vertices.front();
  double six = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - origin, b = mesh.vertices[t[1]] - origin,
               c = mesh.vertices[t[2]] - origin;
    six += a.dot(b.cross(c));
  }
  return six / 6.0;
}

double surfaceArea(const TriangleMesh& mesh) {
  double two = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[t[0]];
    two += (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm();
  }
  return two / 2.0;
}

std::vector<Vec3> scaledBy(double factor, std::vector<Vec3> points) {
  for (Vec3& p : points) p *= factor;
  return points;
}

Box boundingBox(const TriangleMesh& mesh) {
  Box box;
  for (const Vec3& v : mesh.vertices) box.add(v);
  return box;
}

std::vector<Vec3> placedVertices(const TriangleMesh& mesh, const Placement& placement) {
  std::vector<Vec3> out;
  out.reserve(mesh.vertices.size());
  for (const Vec3& v : mesh.vertices) out.push_back(placement(v));
  return out;
}

TriangleMesh placed(const TriangleMesh& mesh, const Placement& placement) {
  TriangleMesh out;
  out.vertices = placedVertices(mesh, placement);
  out.triangles = mesh.triangles;
  return out;
}

void flip(TriangleMesh& mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
}

}  // namespace packmesh
