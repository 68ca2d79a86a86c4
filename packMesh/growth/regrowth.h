// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The end of a packing: the last cells that meet are shrunk and grow again.
#pragma once

#include <cstdint>
#include <functional>

#include "packMesh/growth/local_growth.h"

namespace packmesh {

/// How regrowth went.
struct RegrowthSums {
  std::int64_t rounds = 0;                    ///< calls
  std::int64_t cells = 0;                     ///< shrunk
  std::int64_t clusters = 0, unfinished = 0;  ///< neighbouring ones grow together; did not reach scale 1
  std::int64_t alone = 0;                     ///< clusters for which nobody else had to make way
  double smallest = 1.0;                      ///< scale that any cell was shrunk to
  GrowthStatistics growth;
  double seconds = 0.0;  ///< CPU [s]
};

/// Cells that meet others or the wall are shrunk until none do, and grow back in planes of their own, one
/// cluster of neighbours after the other; where that is not enough, cells next to them make way. All other
/// cells stay.
/// @param faults of the state: who meets whom, who is not inside the lumen
/// @param state all cells at scale 1; on return, if all got there again, free of overlap, else as it was
/// @return whether all did
bool regrow(const GrowthScene& scene, const GrowthSettings& settings, const BuilderFactory& factory,
            const std::function<bool()>& stop, const Certificate& faults, GrowthState& state,
            RegrowthSums& sums);

}  // namespace packmesh
