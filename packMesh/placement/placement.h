// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Random initial positions.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "packMesh/container/container.h"
#include "packMesh/core/pose.h"
#include "packMesh/parallel/threads.h"
#include "packMesh/relaxation/freedom.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// Cells of one species to be placed.
struct PlacementInput {
  const Shape* shape = nullptr;
  const Wall* wall = nullptr;  ///< nullptr: no wall
  std::int64_t firstId = 0;    ///< global id of the first cell
  std::int64_t count = 0;
  const Freedom* freedom = nullptr;  ///< nullptr: unrestricted
  Threads threads = {};
};

/// Random poses of scale 1, within the species' freedom: centres uniform over the lumen, but more evenly
/// spread than independent points (and, where there is room, as far from the wall as the smallest
/// half-thickness of the shape); orientations uniform, or the identity without `rotate`. Cells overlap. Each
/// pose depends only on the seed and the cell's id.
/// @param stop polled occasionally; true leaves the remaining cells at their default poses. Empty: never
std::vector<Pose> placeRandomly(const PlacementInput& input, const Box& bounds, std::uint64_t seed,
                                bool rotate, const std::function<bool()>& stop = {});

}  // namespace packmesh
