// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cells outside of the stages that move them.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/core/pose.h"

namespace packmesh {

/// A cell of a state or of a running simulation. Numbers such as the residual of a fit are columns beside the
/// cells.
struct Cell {
  std::int64_t id = 0;       ///< among the cells of the file or of the simulation
  std::int32_t species = 0;  ///< index into their kinds or types
  Pose pose;
  /// Of a mesh of its own, in the order and frame of the template [µm]; empty: it has that of the template.
  std::vector<Vec3> vertices = {};
  /// Of these, in a state of a packing: index into Physics::shapes of what was packed; -1: not known.
  std::int32_t shape = -1;
};

/// A cell as the numbers written to files place it: certificate and acceptance refer to these, which are not
/// those of a pose to the last bit.
struct PlacedCell {
  std::int32_t species = 0;  ///< index into Physics::species
  std::int32_t shape = 0;    ///< index into Physics::shapes
  Placement placement;
};
static_assert(sizeof(PlacedCell) == 8 + sizeof(Placement), "there are many");

}  // namespace packmesh
