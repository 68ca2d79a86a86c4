// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/face_planes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace packmesh {
namespace {

/// The faces of a tetrahedron with four labels are successive pairs, each in a common plane.
bool repeatsPlane(const std::vector<ChordalFace>& faces, std::size_t f) {
  return f > 0 && faces[f - 1].tetrahedron == faces[f].tetrahedron && faces[f - 1].first == faces[f].first &&
         faces[f - 1].second == faces[f].second;
}

/// Largest cosine of the angle between a face's normal and an edge that it cuts.
double largestCosine(const Tetrahedra& t, const ChordalFace& face) {
  double largest = 0.0;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      if (face.first >> i & 1 && face.second >> j & 1) {
        const Vec3 edge = t.corner(face.tetrahedron, j) - t.corner(face.tetrahedron, i);
        largest = std::max(largest, face.normal.dot(edge) / edge.norm());
      }
  return largest;
}

}  // namespace

PlaneConstraints planesOfFaces(const Tetrahedra& t, const ChordalFaces& split,
                               const std::vector<PlacedMesh>& objects, double minimumCosine,
                               const std::vector<double>& reach) {
  std::vector<Mat3> inverse;
  for (const PlacedMesh& object : objects) inverse.push_back(object.placement.linear.inverse());
  double farthest = std::numeric_limits<double>::infinity();
  if (!reach.empty()) farthest = *std::max_element(reach.begin(), reach.end());
  PlaneConstraints planes(objects.size());
  for (std::size_t f = 0; f < split.faces.size(); ++f) {
    const ChordalFace& face = split.faces[f];
    if (face.away > farthest) continue;
    if (repeatsPlane(split.faces, f) || (minimumCosine > 0.0 && largestCosine(t, face) < minimumCosine))
      continue;
    for (int k = 0; k < 4; ++k) {
      const int p = t.tetrahedra[face.tetrahedron][k], label = t.labels[p];
      const bool first = face.first >> k & 1;
      if (!(first || face.second >> k & 1) || !t.isPrimary(label)) continue;
      const TetrahedraBody& body = t.bodies[label];
      if (!reach.empty() && std::abs(face.normal.dot(face.point - t.points[p])) > reach[body.object])
        continue;
      const PlacedMesh& object = objects[body.object];
      const Vec3 given = t.points[p] - body.shift;
      const Vec3 vertex = t.vertices[p] >= 0
                              ? object.mesh->mesh().vertices[t.vertices[p]]
                              : Vec3(inverse[body.object] * (given - object.placement.translation));
      planes[body.object].push_back(
          {vertex, face.point - body.shift, first ? face.normal : Vec3(-face.normal)});
    }
  }
  return planes;
}

}  // namespace packmesh
