// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/tetgen_offenders.h"

#include <algorithm>

#include "packMesh/certificate/periodic_neighbors.h"
#include "packMesh/growth/bodies.h"
#include "packMesh/growth/tetgen_run.h"
#include "packMesh/mesh/mesh_intersection.h"

namespace packmesh {
namespace {

/// Objects whose bounding spheres are further apart than this fraction of the largest radius hardly affect
/// each other.
constexpr double nearFraction = 0.25;

struct Member {
  int object;
  Vec3 shift;
};

bool failsOn(const TetrahedraInput& input, const std::vector<Member>& members) {
  TetgenInput tetgen;
  tetgen.keepHull = true;
  for (const Member& member : members) {
    if (member.object == input.failingObject) return true;
    const PlacedMesh& object = input.objects[member.object];
    const int first = static_cast<int>(tetgen.points.size());
    for (const Vec3& v : object.mesh->mesh().vertices)
      tetgen.points.push_back(object.placement(v) + member.shift);
    if (input.kind == TetrahedraKind::delaunay) continue;
    for (const Triangle& t : object.mesh->mesh().triangles) {
      tetgen.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
      tetgen.triangleLabels.push_back(1 + member.object);
    }
  }
  TetgenFailure failure;
  runTetgen(tetgen, 0, failure);
  return failure.code != 0;
}

}  // namespace

std::string offendersText(const TetrahedraInput& input) {
  std::vector<Sphere> spheres;
  for (std::size_t i = 0; i < input.objects.size(); ++i) {
    const int object = static_cast<int>(i);
    if (failsOn(input, {{object, Vec3::Zero()}})) return "it fails on " + nameOf(input, object) + " alone";
    spheres.push_back(boundingSphere(*input.objects[i].mesh, input.objects[i].placement));
  }
  double largest = 0.0;
  for (const Sphere& sphere : spheres) largest = std::max(largest, sphere.radius);
  const PeriodicNeighbors neighbors(spheres, input.period);
  std::string text;
  for (std::size_t i = 0; i < spheres.size() && text.empty(); ++i)
    neighbors.forEachNear(
        static_cast<std::int64_t>(i), nearFraction * largest, true, [&](const NearPair& pair) {
          const int a = static_cast<int>(pair.first), b = static_cast<int>(pair.second);
          if (text.empty() && failsOn(input, {{a, Vec3::Zero()}, {b, pair.shift}}))
            text = "it fails on " + nameOf(input, a) + " and " + nameOf(input, b) + " together";
        });
  return text.empty() ? "it fails on no single object or pair, only on all together" : text;
}

}  // namespace packmesh
