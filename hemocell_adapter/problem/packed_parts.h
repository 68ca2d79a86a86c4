// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The species as they are packed with certain clearances.
#pragma once

#include <memory>
#include <vector>

#include "hemocell_adapter/settings/request.h"
#include "packMesh/packing/packing_problem.h"

namespace packmesh::hemocell {

/// Cells of one species with the same constraints, which form a species of the problem that is packed.
struct Part {
  int species = 0;
  int region = -1;  ///< in Lumen::regions, or shell of a profile; -1: none
  Species cells;    ///< "RBC", "RBC, fixed", "RBC, region 1"; its shapes are Problem::shapes
};

/// What is packed with these clearances. Made by partsAt() (parts.h).
struct PackedParts {
  Clearances clearances;
  std::vector<std::shared_ptr<const Wall>> walls;  ///< of each species; nullptr: the container's own
  std::vector<Part> parts;
};

}  // namespace packmesh::hemocell
