// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Random initial positions.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/core/pose.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

/// Random poses of scale 1 of cells of a species, within its freedom: centres uniform over the lumen, but
/// more evenly spread than independent points (and, where there is room, as far from the wall as the smallest
/// half-thickness of the shape); orientations uniform, or the identity without Physics::rotate. Cells
/// overlap. Each pose depends only on the physics, the seed among them, and the cell's id. If interrupted,
/// the remaining cells have default poses.
/// @param firstId of `count` cells: numbers over all species
std::vector<Pose> placeRandomly(const Physics& physics, const Execution& execution, int species,
                                std::int64_t firstId, std::int64_t count);

}  // namespace packmesh
