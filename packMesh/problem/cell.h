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
};

/// A cell as the numbers written to files place it: certificate and acceptance refer to these, which are not
/// those of a pose to the last bit. There are many, and the shape is that of the species.
struct PlacedCell {
  int species = 0;  ///< index into Physics::species
  Placement placement;
};

}  // namespace packmesh
