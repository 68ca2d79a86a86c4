// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Physics for tests of single stages.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "packMesh/container/primitives.h"
#include "packMesh/problem/physics.h"

namespace packmesh::test {

inline std::shared_ptr<const Container> cubicBox(double edge, bool periodic) {
  return makeBox(Box{Vec3::Zero(), Vec3::Constant(edge)}, {periodic, periodic, periodic});
}

/// Shapes in a container, one species of each.
inline Physics physicsOf(const std::vector<std::shared_ptr<const Shape>>& shapes,
                         std::shared_ptr<const Container> container) {
  Physics physics;
  for (const auto& shape : shapes) physics.add("cell", shape, 0);
  physics.container = std::move(container);
  return physics;
}

}  // namespace packmesh::test
