// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/shape/inner_points.h"

#include "packMesh/shape/surface_distance.h"

namespace packmesh {
namespace {

/// Element n of the van der Corput sequence with the given base [fraction].
double vanDerCorput(int n, int base) {
  double value = 0.0, digit = 1.0;
  for (; n > 0; n /= base) value += (n % base) * (digit /= base);
  return value;
}

/// Points inside the template of a deformed cell, each moved as its nearest vertex.
std::vector<Vec3> movedWith(std::vector<Vec3> points, const Shape& deformed) {
  const std::vector<Vec3>&from = deformed.undeformed()->mesh().vertices, &to = deformed.mesh().vertices;
  for (Vec3& p : points) {
    std::size_t nearest = 0;
    for (std::size_t v = 1; v < from.size(); ++v)
      if ((from[v] - p).squaredNorm() < (from[nearest] - p).squaredNorm()) nearest = v;
    p += to[nearest] - from[nearest];
  }
  return points;
}

}  // namespace

std::vector<Vec3> innerPoints(const Shape& shape, int count) {
  if (shape.undeformed()) return movedWith(innerPoints(*shape.undeformed(), count), shape);
  const SurfaceDistance surface(shape);
  const Box box = boundingBox(shape.mesh());
  std::vector<Vec3> points;
  constexpr int patience = 1000;
  for (int n = 1; static_cast<int>(points.size()) < count && n < patience * count; ++n) {
    const Vec3 at(vanDerCorput(n, 2), vanDerCorput(n, 3), vanDerCorput(n, 5));
    const Vec3 p = box.lo + at.cwiseProduct(box.size());
    if (surface.sample(p).distance < 0.0) points.push_back(p);
  }
  if (points.empty()) points.push_back(Vec3::Zero());
  return points;
}

}  // namespace packmesh
