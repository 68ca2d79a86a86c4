// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What is packed.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "packMesh/container/container.h"
#include "packMesh/core/pose.h"
#include "packMesh/problem/freedom.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// One kind of cell and its number.
struct Species {
  std::string name;
  std::shared_ptr<const Shape> shape;
  std::int64_t count = 0;
  /// The wall for this species; nullptr: the container's own.
  std::shared_ptr<const Wall> wall;
  bool inHematocrit = true;  ///< its volume is part of the hematocrit
  /// Initial poses of the first cells, scale 1; the others start at random.
  std::vector<Pose> start = {};
  Freedom freedom = {};  ///< the cells of fixed species all have initial poses
  /// Starts in columns (packMesh/placement/columns.h) instead of at random. At most one species, which is
  /// unconstrained and has no initial poses, in boxes that are periodic along all axes.
  bool inColumns = false;
  /// Requested number before rounding to `count`; 0: the same. If fewer cells are tried, their numbers are
  /// derived from this one, so that larger and smaller requests try the same numbers of every species.
  double asked = 0.0;
  /// Of cells of one kind with several constraints, each a species here: the number of their kind, by which
  /// results name them; -1: a kind of its own, with the number of this species.
  int kind = -1;
};

}  // namespace packmesh
