// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What a relaxation knows beyond its bodies, whenever it is about to list pairs anew.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "packMesh/relaxation/contact_solver.h"

namespace packmesh {

/// Clearance that pairs (ids, the smaller one first) keep on top of the problem's [µm].
using ExtraClearances = std::map<std::pair<std::int64_t, std::int64_t>, float>;

/// The same on all ranks. With the bodies this is all that the sweeps to come depend on.
struct RelaxationState {
  /// Cells per species in the beginning: blocks and masses are chosen for them. Empty: the bodies given.
  std::vector<std::int64_t> counts;
  std::array<int, 3> blocks = {0, 0, 0};  ///< along each axis
  std::int64_t sweeps = 0;                ///< done
  std::int64_t listedInSweep = 0;         ///< when pairs were listed last
  double skin = 0.0;     ///< pairs are listed up to this much further than they can touch [µm]
  double slack = 0.0;    ///< of the last sweep [µm]
  bool coarsely = true;  ///< whether coarse samples have been enough so far
  SweepSums last;        ///< of the last sweep
  ExtraClearances extraClearance;
  std::set<std::int64_t> disturbed;  ///< cells that something was demanded of since the last sweep
};

}  // namespace packmesh
