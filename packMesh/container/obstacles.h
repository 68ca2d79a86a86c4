// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Lumens with obstacles.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "packMesh/container/container.h"

namespace packmesh {

/// A body that cells cannot enter: a closed, outward-oriented mesh (see repairClosed) and its name for
/// messages.
struct Obstacle {
  TriangleMesh surface;
  std::string name;
};

/// `outer` minus the union of the obstacles. Obstacles can overlap one another and extend beyond `outer`;
/// along periodic axes they repeat.
///
/// The volume is exact if the obstacles are disjoint and `outer` is a box or contains them entirely,
/// otherwise accurate to about 1e-4. surface() bounds the remaining lumen; where two surfaces cross,
/// triangles extend into the other body.
/// @throws InputError if an obstacle lies outside `outer`, or nothing remains
std::shared_ptr<const Container> subtractObstacles(std::shared_ptr<const Container> outer,
                                                   std::vector<Obstacle> obstacles);

/// Volume of the part of a closed mesh in `box` [µm³], by the divergence theorem on triangles clipped to the
/// sides of the box; exact up to rounding.
double volumeInside(const TriangleMesh& mesh, const Box& box);

}  // namespace packmesh
