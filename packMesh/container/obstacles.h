// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Lumens with bodies in them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "packMesh/container/container.h"

namespace packmesh {

/// A body cells cannot enter: a closed, outward-oriented mesh (see repairClosed) and its name in messages.
struct Obstacle {
  TriangleMesh surface;
  std::string name;
};

/// `outer` without the union of the obstacles. They may overlap one another and stick out of it; along
/// periodic axes they repeat.
///
/// The volume is exact where the obstacles are apart and `outer` is a box or holds them wholly, otherwise to
/// within about 1e-4. surface() is what bounds the rest: where two surfaces cross, triangles reach into the
/// other body.
/// @throws InputError when an obstacle lies outside `outer`, or nothing is left
std::shared_ptr<const Container> subtractObstacles(std::shared_ptr<const Container> outer,
                                                   std::vector<Obstacle> obstacles);

/// Volume of the part of a closed mesh that lies in `box` [µm³]: by the divergence theorem on triangles
/// clipped to the sides of the box, exact up to rounding.
double volumeInside(const TriangleMesh& mesh, const Box& box);

}  // namespace packmesh
