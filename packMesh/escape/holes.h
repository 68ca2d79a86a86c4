// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Holes between cells.
#pragma once

#include <vector>

#include "packMesh/growth/growth_scene.h"
#include "packMesh/mesh/sphere_grid.h"

namespace packmesh {

/// Disjoint spheres in the free space of a packing, the largest first: circumspheres of the tetrahedra
/// between cells (thesis 3.1.3), shrunk until they touch neither cell nor wall.
/// @param least smallest radius of interest [µm]
std::vector<Sphere> findHoles(const GrowthScene& scene, const std::vector<Body>& state, double least);

}  // namespace packmesh
