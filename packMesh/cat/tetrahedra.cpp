// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/tetrahedra.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "packMesh/core/error.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/core/vector.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/mesh_repair.h"
#include "packMesh/mesh/neighbor_search.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/parallel/blocks.h"

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

std::string nameOf(const TetrahedraInput& input, int object) {
  if (object < static_cast<int>(input.names.size())) return input.names[object];
  return "object " + std::to_string(object);
}

Placement placementOf(const TetrahedraInput& input, const TetrahedraBody& body) {
  Placement placement = input.objects[body.object].placement;
  placement.translation += body.shift;
  return placement;
}

std::vector<TetrahedraBody> bodiesAround(const TetrahedraInput& input, double margin) {
  std::vector<TetrahedraBody> bodies = input.bodies;
  for (std::size_t b = 0; b < bodies.size(); ++b) bodies[b].given = static_cast<int>(b);
  const std::size_t complete = bodies.empty() ? input.objects.size() : 0;
  for (std::size_t i = 0; i < complete; ++i) {
    const Sphere sphere = boundingSphere(*input.objects[i].mesh, input.objects[i].placement);
    Vec3 home = Vec3::Zero();
    for (int k = 0; k < 3; ++k)
      if (input.period[k] > 0.0)
        home[k] = -input.period[k] * std::floor((sphere.center[k] - input.bounds.lo[k]) / input.period[k]);
    forEachImage(sphere.center + home, sphere.radius + margin, input.bounds, input.period,
                 [&](const ImageShift& n) {
                   const Vec3 shift = home + displacement(n, input.period);
                   bodies.push_back({static_cast<int>(i), shift, n == ImageShift{0, 0, 0}});
                 });
  }
  const auto before = [&](const TetrahedraBody& a, const TetrahedraBody& b) {
    const Placement p = placementOf(input, a), q = placementOf(input, b);
    const auto less = [](const auto& u, const auto& v) {
      return std::lexicographical_compare(u.data(), u.data() + u.size(), v.data(), v.data() + v.size());
    };
    return p.translation != q.translation ? less(p.translation, q.translation) : less(p.linear, q.linear);
  };
  std::stable_sort(bodies.begin(), bodies.end(), before);
  return bodies;
}

std::optional<MeshHierarchy> containerAround(const TetrahedraInput& input, double margin) {
  if (!input.container) return std::nullopt;
  std::array<int, 3> images{0, 0, 0};
  const double reach = margin + 2.0 * largestRadius(input);
  for (int k = 0; k < 3; ++k)
    if (input.period[k] > 0.0) images[k] = static_cast<int>(std::ceil(reach / input.period[k]));
  return MeshHierarchy(repeatedSurface(input.container->mesh(), input.bounds, input.period, images));
}

double largestRadius(const TetrahedraInput& input) {
  double radius = 0.0;
  for (const PlacedMesh& object : input.objects)
    radius = std::max(radius, boundingSphere(*object.mesh, object.placement).radius);
  return radius;
}

namespace {

/// Beyond this, squares of lengths overflow in the search for pairs of triangles [µm].
constexpr double farthest = 1e12;

/// Refuses a mesh that does not bound a body. @throws MeshError
void requireSound(const TriangleMesh& mesh, const std::string& name) {
  TriangleMesh copy = mesh;
  const std::vector<std::string> repairs = repairClosed(copy, name);
  if (!repairs.empty()) throw MeshError(repairs.front() + ": the mesh must be repaired first");
}

void requireApart(const TetrahedraInput& input) {
  std::vector<Sphere> spheres;
  for (const PlacedMesh& object : input.objects)
    spheres.push_back(boundingSphere(*object.mesh, object.placement));
  const PeriodicNeighbors neighbors(std::move(spheres), input.period);
  const auto name = [&](std::int64_t object) { return nameOf(input, static_cast<int>(object)); };
  for (std::size_t i = 0; i < input.objects.size(); ++i)
    neighbors.forEachLater(static_cast<std::int64_t>(i), 0.0, [&](const NearPair& pair) {
      const PlacedMesh &a = input.objects[pair.first], &b = input.objects[pair.second];
      Placement moved = b.placement;
      moved.translation += pair.shift;
      const MeshRelation relation = relate(*a.mesh, a.placement, *b.mesh, moved).relation;
      const std::string image =
          pair.shift.isZero() ? "" : ", as an image moved by " + toText(pair.shift) + " µm,";
      if (relation == MeshRelation::firstInside)
        throw InputError(name(pair.first) + " is inside " + name(pair.second) + image);
      if (relation == MeshRelation::secondInside)
        throw InputError(name(pair.second) + image + " is inside " + name(pair.first));
      if (relation == MeshRelation::meet)
        throw InputError(name(pair.first) + " and " + name(pair.second) + image + " meet");
    });
}

void requireInside(const TetrahedraInput& input) {
  requireSound(input.container->mesh(), "the container");
  const std::optional<MeshHierarchy> container = containerAround(input, 0.0);
  for (const TetrahedraBody& body : bodiesAround(input, 0.0)) {
    if (!body.primary) continue;
    const MeshRelation relation =
        relate(*input.objects[body.object].mesh, placementOf(input, body), *container, Placement()).relation;
    if (relation == MeshRelation::meet)
      throw InputError(nameOf(input, body.object) + " meets the container's wall");
    if (relation != MeshRelation::firstInside)
      throw InputError(nameOf(input, body.object) + " is outside the container");
  }
}

}  // namespace

void requireValid(const TetrahedraInput& input) {
  std::map<const MeshHierarchy*, int> firstOf;
  for (std::size_t i = 0; i < input.objects.size(); ++i) {
    const int object = static_cast<int>(i);
    const Placement& placement = input.objects[i].placement;
    if (!placement.linear.allFinite() || !placement.translation.allFinite() ||
        !(placement.linear.determinant() > 0.0))
      throw InputError(nameOf(input, object) + " has a placement that is not finite or turns it inside out");
    if (placement.translation.cwiseAbs().maxCoeff() > farthest)
      throw InputError(nameOf(input, object) + " is more than 1e12 µm away from the origin");
    if (firstOf.emplace(input.objects[i].mesh, object).second)
      requireSound(input.objects[i].mesh->mesh(), nameOf(input, object));
  }
  requireApart(input);
  if (input.container) requireInside(input);
}

}  // namespace packmesh
