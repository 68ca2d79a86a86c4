// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/surface_wall.h"

#include <algorithm>
#include <cmath>

#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/mesh_tree.h"

namespace packmesh {

SurfaceWall::SurfaceWall(const TriangleMesh& surface, int axis, double lo, double period)
    : surface_(surface), box_(boundingBox(surface)), axis_(axis), lo_(lo), period_(period) {}

int SurfaceWall::imageOf(double x) const {
  return periodic() ? static_cast<int>(std::floor((x - lo_) / period_)) : 0;
}

WallVerdict SurfaceWall::examine(const PlacedHierarchy& cell, double gapOfInterest, double nearest,
                                 const std::function<bool(const Vec3&)>& contains) const {
  const auto violationThat = [](const char* what) {
    WallVerdict verdict;
    verdict.violation = what;
    return verdict;
  };
  nearest = std::min(nearest, gapOfInterest);
  Box box;
  for (std::size_t i = 0; i < cell.vertexCount(); ++i) box.add(cell.vertex(i));
  // A mesh can extend beyond the ends between which it repeats: examine one more image on either side.
  const Box reach = box.grownBy(gapOfInterest);
  const int first = imageOf(reach.lo[axis_]) - periodic(), last = imageOf(reach.hi[axis_]) + periodic();
  for (int image = first; image <= last; ++image) {
    const Placement moved{Mat3::Identity(), shifted(Vec3::Zero(), image)};
    if (!reach.grownBy(tolerance::culling).meets({shifted(box_.lo, image), shifted(box_.hi, image)}))
      continue;
    const double gap = surfaceGap(cell.hierarchy, cell.placement, surface_, moved, nearest);
    if (gap == 0.0) return violationThat("meets the wall");
    nearest = std::min(nearest, gap);
  }
  for (const int v : cell.hierarchy.tree().samples)
    if (!contains(cell.vertex(v))) return violationThat("is outside the lumen");
  for (int image = first; image <= last; ++image)
    for (const int v : surface_.tree().samples) {
      const Vec3 sample = shifted(surface_.mesh().vertices[v], image);
      if (box.contains(sample) && isInside(sample, cell.hierarchy, cell.placement))
        return violationThat("encloses part of the wall");
    }
  WallVerdict verdict;
  if (nearest < gapOfInterest) verdict.gap = nearest;
  return verdict;
}

}  // namespace packmesh
