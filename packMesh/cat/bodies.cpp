// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/bodies.h"

#include <algorithm>
#include <cmath>

#include "packMesh/cat/repeated_surface.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/parallel/periodic_images.h"

namespace packmesh {

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

}  // namespace packmesh
