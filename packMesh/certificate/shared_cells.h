// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Distribution of the cells of a finished packing over the ranks by their positions.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/parallel/communicator.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

/// The cells in this rank's part of the lumen, and copies of those around them; sorted by number.
struct SharedCells {
  std::vector<PlacedCell> cells;
  std::vector<bool> own;
  std::vector<std::int64_t> numbers;  ///< among the cells of all ranks
  struct Origin {
    int rank, index;
  };
  std::vector<Origin> origins;  ///< where each cell comes from
};

/// Divides the lumen into as many parts as there are ranks, with about as many cells in each. Collective.
/// @param own cells of this rank, numbered globally in rank order
/// @param largestGap copies of all cells that are less than this from those of the part are included [µm]
SharedCells sharedInSpace(const std::vector<PlacedCell>& own, const Physics& physics, double largestGap,
                          const Communicator& ranks);

}  // namespace packmesh
