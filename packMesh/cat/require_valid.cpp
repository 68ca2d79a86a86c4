// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/require_valid.h"

#include <map>
#include <vector>

#include "packMesh/certificate/periodic_neighbors.h"
#include "packMesh/core/error.h"
#include "packMesh/core/vector_text.h"
#include "packMesh/cat/bodies.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/mesh_repair.h"

namespace packmesh {
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
