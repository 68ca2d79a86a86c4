// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Holes between cells.
#pragma once

#include <map>
#include <vector>

#include "packMesh/mesh/mesh_hierarchy.h"
#include "packMesh/mesh/sphere_grid.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"
#include "packMesh/relaxation/body.h"
#include "packMesh/shape/surface_distance.h"

namespace packmesh {

/// Finds holes: disjoint spheres in the free space of a packing, circumspheres of the tetrahedra between
/// cells (thesis 3.1.3), shrunk until they touch neither cell nor wall.
class Holes {
 public:
  /// References its arguments, which must outlive this.
  Holes(const Physics& physics, const Execution& execution);

  /// Holes with centres in a region, the largest first; none if TetGen fails.
  /// @param state the cells as far as they matter: if the region is only part of the container, those that
  ///   may be nearer to it than the largest radius of a shape. No hole is larger then
  /// @param region a block of the container's bounds
  /// @param least smallest radius of interest [µm]
  std::vector<Sphere> in(const Box& region, const std::vector<Body>& state, double least) const;

 private:
  struct Surroundings;
  Surroundings surroundingsOf(const Box& region, const std::vector<Body>& state) const;
  double freeAround(const Vec3& p, const Surroundings& around) const;
  std::vector<Vec3> circumcentres(const Surroundings& around) const;

  const Physics& physics_;
  const Execution& execution_;
  std::map<int, std::pair<SurfaceDistance, MeshHierarchy>> shapes_;  ///< in use, with their coarsest meshes
};

}  // namespace packmesh
