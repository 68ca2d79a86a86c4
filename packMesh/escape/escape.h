// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Escape from local maxima of the coverage (thesis 3.1.3), for mixtures of shapes.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "packMesh/escape/rooms.h"

namespace packmesh {

struct EscapeSettings {
  int orientations = 3;               ///< number of random orientations tried in each room
  int swapRounds = 6;                 ///< maximum number of groups of cells that exchange places
  int groupSize = 12;                 ///< number of cells in a group
  int holes = 60;                     ///< number of holes tried, largest first
  std::vector<std::int64_t> reserve;  ///< per species: number of bodies that can be added; empty: none
};

/// Result of one phase.
struct EscapePhase {
  std::string name;
  double coverage = 0.0;                ///< afterwards: volume of all cells as scaled / volume of the lumen
  std::int64_t cells = 0, full = 0;     ///< after the phase: number of cells; of full-size cells
  std::int64_t tried = 0, changed = 0;  ///< number of rooms or holes
  double seconds = 0.0;                 ///< CPU time [s]
};

/// Swaps cells, enlarges them, replaces them from a reserve and fills holes, in this order, and then grows
/// all cells. No phase lowers the coverage; every state is free of overlap. Full-size cells remain full-size
/// unless swapping them gains more volume elsewhere.
///
/// - Swapping: cells of a group, no two of which are neighbours, exchange places: each is scored by the
/// volume it
/// reaches in each room, and the bipartite matching with the largest sum is applied.
/// - Enlargement: cells below full size grow in their CDT cells, also from random orientations.
/// - Replacement: cells below full size are replaced by bodies from the reserve that reach more volume.
/// - Hole filling: circumspheres of tetrahedra in the free space, largest first, are rooms for bodies from
/// the
/// reserve; bodies that do not reach full size are rejected.
/// @param state free of overlap; cells can be added at its end and can change their species
/// @param observe called after every phase; can be empty
/// @return the initial state and every phase
std::vector<EscapePhase> escape(const GrowthScene& scene, const GrowthSettings& growth,
                                const EscapeSettings& settings, const PlaneFunctionFactory& factory,
                                const std::function<bool()>& stop,
                                const std::function<void(const std::vector<Body>&)>& observe,
                                std::vector<Body>& state);

}  // namespace packmesh
