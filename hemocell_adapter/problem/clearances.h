// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How much room packing leaves between membranes, and to the wall, when the user leaves it to
/// packMesh.
///
/// HemoCell needs none to load a cell, but its cells move: a vertex that gets onto a wall node is deleted,
/// and the whole cell with it, and membranes nearer than the reach of the immersed boundary feel each other
/// from the first step. docs/explanation/method.md tells what was measured.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "hemocell_adapter/problem/scene.h"

namespace packmesh::hemocell {

/// What packing tries one after the other, the widest first; the last are those that are demanded, the only
/// ones with escapes, each of which takes as long as a whole packing.
std::vector<Clearances> clearanceLevels(const Scene& scene);

/// Whether packing leaves more room than is demanded where that succeeds.
bool triesMoreClearance(const Job& job);

/// What one attempt to pack with some clearances may use up.
struct AttemptLimits {
  std::int64_t maxSweeps = 0;  ///< 0: those of the job
  double maxSeconds = 0.0;     ///< 0: no limit
  bool fewerCells = true;      ///< out of reach: whether a packing of fewer cells is wanted
};

/// A packing, and the clearances it was certified with.
struct RoomyPacking {
  PackingResult result;
  Clearances clearances;
};

/// Packs with one pair of clearances. @return nothing when they are impossible
using Attempt =
    std::function<std::optional<PackingResult>(const Clearances& clearances, const AttemptLimits& limits)>;

/// Attempts the levels from `first` on until one is certified, then, where the job asks for the largest
/// clearance, larger ones until time or progress ends. Deterministic but for limits of time.
/// @param cells to be packed
/// @param elapsed wall time since packing began [s], the same on all ranks
RoomyPacking packWithRoom(const Job& job, const std::vector<Clearances>& levels, std::size_t first,
                          std::int64_t cells, const std::function<double()>& elapsed, const Attempt& attempt);

}  // namespace packmesh::hemocell
