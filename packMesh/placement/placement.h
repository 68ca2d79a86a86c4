// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Where cells start.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "packMesh/container/container.h"
#include "packMesh/core/pose.h"
#include "packMesh/relaxation/freedom.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// Cells of one species to be placed.
struct PlacementInput {
  const Shape* shape = nullptr;
  const Wall* wall = nullptr;  ///< nullptr: none
  std::int64_t firstId = 0;    ///< global id of the first cell
  std::int64_t count = 0;
  const Freedom* freedom = nullptr;  ///< nullptr: free
};

/// Random poses of scale 1: centres uniform over the lumen, and more evenly spread than independent ones (as
/// far from the wall as the thinnest part of the shape, where there is room), orientations uniform (or the
/// identity), both as far as the species' freedom allows. Cells overlap. Each pose is a function of the seed
/// and the cell's id alone.
/// @param stop polled now and then; true leaves the rest of the cells where they are by default. Empty: never
std::vector<Pose> placeRandomly(const PlacementInput& input, const Box& bounds, std::uint64_t seed,
                                bool rotate, const std::function<bool()>& stop = {});

}  // namespace packmesh
