// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Escaping local maxima of the coverage (thesis 3.1.3), for mixtures of shapes.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "packMesh/escape/rooms.h"

namespace packmesh {

struct EscapeSettings {
  int orientations = 3;  ///< random ones that a body is tried with in a room
  int swapRounds = 6;    ///< groups of cells that change places, at most
  int groupSize = 12;    ///< cells in a group
  int holes = 60;        ///< tried, largest first
  std::vector<std::int64_t>
      reserve;  ///< bodies of each species that may be used beyond those there are; empty: none
};

/// What one phase did.
struct EscapePhase {
  std::string name;
  double coverage = 0.0;                ///< after it: volume of all cells as large as they are / lumen's
  std::int64_t cells = 0, full = 0;     ///< after it; of full size
  std::int64_t tried = 0, changed = 0;  ///< rooms or holes
  double seconds = 0.0;                 ///< CPU [s]
};

/// Object swapping, enlargement, replacement from a reserve and hole filling, one after the other, then
/// growth of all. No phase lowers the coverage; every state is free of overlap. Full-size cells stay
/// full-size, but where swapping gains more volume elsewhere.
///
/// - Swapping: cells of a group, no two of them neighbours, change places: each is scored by the volume it
///   reaches in each room, and the bipartite matching with the largest sum is taken.
/// - Enlargement: cells that are not full grow in their CDT cells, also turned at random.
/// - Replacement: cells that are not full give way to bodies from the reserve that reach more volume.
/// - Hole filling: the circumspheres of tetrahedra in the free space, the largest first, are rooms for bodies
///   from the reserve; those that do not reach full size are not taken.
/// @param state free of overlap; cells may be added at its end, and change their species
/// @param observe called after every phase; may be empty
/// @return the start and every phase
std::vector<EscapePhase> escape(const GrowthScene& scene, const GrowthSettings& growth,
                                const EscapeSettings& settings, const PlaneFunctionFactory& factory,
                                const std::function<bool()>& stop,
                                const std::function<void(const std::vector<Body>&)>& observe, std::vector<Body>& state);

}  // namespace packmesh
