// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The state of a relaxation besides its bodies, at any time just before a rebuild of the neighbour
/// list.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "packMesh/relaxation/contact_solver.h"

namespace packmesh {

/// Extra clearance of pairs (ids, the smaller one first) in addition to the problem's [µm].
using ExtraClearances = std::map<std::pair<std::int64_t, std::int64_t>, float>;

/// The same on all ranks. With the bodies this is all that the following sweeps depend on.
struct RelaxationState {
  /// Initial number of cells per shape, from which blocks and masses are derived. Empty: of the bodies
  /// given.
  std::vector<std::int64_t> counts;
  std::array<int, 3> blocks = {0, 0, 0};  ///< along each axis
  std::int64_t sweeps = 0;                ///< done
  std::int64_t listedInSweep = 0;         ///< of the last rebuild of the neighbour list
  double skin = 0.0;                      ///< Verlet skin of the neighbour list [µm]
  double slack = 0.0;                     ///< of the last sweep [µm]
  bool coarsely = true;                   ///< whether coarse samples have sufficed so far
  SweepSums last;                         ///< of the last sweep
  ExtraClearances extraClearance;
  std::set<std::int64_t> disturbed;  ///< cells of which something was demanded since the last sweep
};

}  // namespace packmesh
