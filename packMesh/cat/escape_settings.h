// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The parameters of escapes.
#pragma once

#include <cstdint>
#include <vector>

namespace packmesh {

/// Numbers per block do not depend on the number of ranks: blocks are at least four largest radii wide, and
/// a container in which no two such blocks fit side by side is one block.
struct EscapeSettings {
  int orientations = 3;               ///< number of random orientations tried in each room
  int swapRounds = 6;                 ///< largest number of groups of cells, per block, that exchange places
  int groupSize = 12;                 ///< number of cells in a group
  int holes = 60;                     ///< number of holes tried per block, largest first
  std::vector<std::int64_t> reserve;  ///< per species: number of bodies that can be added; empty: none
};

}  // namespace packmesh
