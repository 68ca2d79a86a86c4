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

/// `outer` without the obstacles. They may stick out of it; along periodic axes they repeat.
/// @throws InputError when an obstacle lies outside `outer`, two of them meet, or nothing is left
std::shared_ptr<const Container> subtractObstacles(std::shared_ptr<const Container> outer,
                                                   std::vector<Obstacle> obstacles);

/// Volume of the part of a closed mesh that lies in `box` [µm³]: by the divergence theorem on triangles
/// clipped to the sides of the box, exact up to rounding.
double volumeInside(const TriangleMesh& mesh, const Box& box);

}  // namespace packmesh
