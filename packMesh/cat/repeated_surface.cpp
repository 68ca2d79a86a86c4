// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/repeated_surface.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "packMesh/core/error.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/merge_vertices.h"
#include "packMesh/mesh/mesh_repair.h"

namespace packmesh {
namespace {

void append(TriangleMesh& mesh, const TriangleMesh& other, const Vec3& shift) {
  const int n = static_cast<int>(mesh.vertices.size());
  for (const Vec3& v : other.vertices) mesh.vertices.push_back(v + shift);
  for (const Triangle& t : other.triangles) mesh.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
}

TriangleMesh repeatedAlong(const TriangleMesh& surface, int axis, double lo, double hi, int images) {
  const std::string name = std::string("the container, continued along ") + "xyz"[axis] + " by its images";
  const double size = boundingBox(surface).size().norm();
  TriangleMesh wall{surface.vertices, {}}, low = wall, high = wall;
  const auto within = [&](const Triangle& t, double plane) {
    return std::all_of(t.begin(), t.end(), [&](int v) {
      return std::abs(surface.vertices[v][axis] - plane) < tolerance::flatCapFraction * size;
    });
  };
  for (const Triangle& t : surface.triangles)
    (within(t, lo) ? low : within(t, hi) ? high : wall).triangles.push_back(t);
  if (low.triangles.empty() || high.triangles.empty()) throw InputError(name + ": its ends are not flat");
  TriangleMesh mesh;
  for (int image = -images; image <= images; ++image)
    append(mesh, wall, image * (hi - lo) * Vec3::Unit(axis));
  append(mesh, low, -images * (hi - lo) * Vec3::Unit(axis));
  append(mesh, high, images * (hi - lo) * Vec3::Unit(axis));
  const std::vector<int> first = firstOfNearVertices(mesh.vertices, tolerance::crackFraction * size);
  for (Triangle& t : mesh.triangles)
    for (int& v : t) v = first[v];
  try {
    repairClosed(mesh, name);
  } catch (const MeshError& error) {
    throw InputError(std::string(error.what()) + "; the vertices of its two ends must match");
  }
  return mesh;
}

}  // namespace

TriangleMesh repeatedSurface(const TriangleMesh& surface, const Box& bounds, const Vec3& period,
                             const std::array<int, 3>& images) {
  TriangleMesh mesh = surface;
  for (int k = 0; k < 3; ++k)
    if (period[k] > 0.0 && images[k] > 0)
      mesh = repeatedAlong(mesh, k, bounds.lo[k], bounds.hi[k], images[k]);
  return mesh;
}

}  // namespace packmesh
