// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The clearances between membranes and to the wall if the user does not specify them.
///
/// HemoCell needs none to load a cell, but its cells move: a vertex that moves onto a wall node is deleted
/// together with its cell, and membranes nearer than the range of the immersed boundary interact from the
/// first step. docs/explanation/method.md reports the measurements.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// The clearances that are tried in sequence, the widest first; the last are those demanded, the only ones
/// with a reserve, which takes as long as a complete packing.
std::vector<Clearances> clearanceLevels(const Problem& problem);

/// The least clearance to a solid wall that packing aims at if none is demanded [µm].
double leastWallRoom(const Request& request);

/// Whether packing aims at larger clearances than demanded, if they can be achieved.
bool triesMoreClearance(const Request& request);

/// How far a search for clearances goes: as the request says, or less.
struct SearchLimits {
  SearchLimits(const Request& request);

  double maxSeconds;                          ///< 0: no limit
  std::optional<std::int64_t> maxIterations;  ///< empty: no limit that was stated
  bool fewerCells = true;  ///< if not all cells can be packed, the densest packing of fewer is searched for
  bool soft;               ///< the cells are soft, and stay where they are
};

/// Limits of one attempt to pack with given clearances.
struct AttemptLimits {
  std::int64_t maxSweeps = 0;     ///< 0: those of the request
  std::int64_t sweepsForFew = 0;  ///< further ones if only few contacts are left then
  double maxSeconds = 0.0;        ///< 0: no limit
  bool someCloser = false;        ///< a few cells may keep less
  bool fewerCells = true;         ///< if not feasible: whether a packing of fewer cells is requested
};

/// Packs with one pair of clearances. @return nothing if they are impossible
using PackWith =
    std::function<std::optional<PackingResult>(const Clearances& clearances, const AttemptLimits& limits)>;

/// Tries the levels from `first` on until one is certified; if the request asks for the largest clearance,
/// then larger ones until the time limit or convergence. Deterministic except for time limits.
/// @param all limits of all attempts together @param cells to be packed
/// @param elapsed wall time since packing began [s], the same on all ranks
PackingResult packWithClearances(const Request& request, const SearchLimits& all,
                                 const std::vector<Clearances>& levels, std::size_t first, std::int64_t cells,
                                 const std::function<double()>& elapsed, const PackWith& packWith);

}  // namespace packmesh::hemocell
