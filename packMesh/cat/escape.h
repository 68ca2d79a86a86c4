// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Escape from local maxima of the coverage (thesis 3.1.3), for mixtures of shapes.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "packMesh/cat/cat_settings.h"
#include "packMesh/cat/rooms.h"

namespace packmesh {

/// Result of one phase: sums over all ranks, CPU time of this rank.
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
/// - Enlargement: cells below full size grow in their CAT cells, also from random orientations.
/// - Replacement: cells below full size are replaced by bodies from the reserve that reach more volume.
/// - Hole filling: circumspheres of tetrahedra in the free space, largest first, are rooms for bodies from
/// the
/// reserve; bodies that do not reach full size are rejected.
///
/// All phases but growth work block by block: blocks of one colour at the same time, each on the rank that
/// owns it. No rank has all cells, and states do not depend on the number of ranks. The reserve is divided
/// evenly among the blocks; what they leave is divided again among those that could use more.
/// @param stop asked between the blocks of two colours by all ranks together; the same on all. Within blocks,
///   Execution::interrupted abandons the work of this rank; then `stop` must become true
/// @param observe called after every phase with this rank's cells; can be empty
/// @param own this rank's cells, in any distribution; all together free of overlap. On return sorted by id;
///   cells can have been added, with the next free ids, and can have another species
/// @return the initial state and every phase
std::vector<EscapePhase> escape(const Physics& physics, const Execution& execution,
                                const GrowthSettings& growth, const EscapeSettings& settings,
                                const PlaneFunctionFactory& factory, const std::function<bool()>& stop,
                                const std::function<void(const std::vector<Body>&)>& observe,
                                std::vector<Body>& own);

}  // namespace packmesh
