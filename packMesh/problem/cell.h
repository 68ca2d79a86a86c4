// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cells of a packing.
#pragma once

#include "packMesh/core/pose.h"

namespace packmesh {

/// One cell as written to files: species and placement.
struct PlacedCell {
  int species = 0;  ///< index into Physics::species
  Placement placement;
};

}  // namespace packmesh
