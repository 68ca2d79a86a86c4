// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How a packing is computed: what does not change the result, unless a limit ends the run early.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "packMesh/parallel/communicator.h"
#include "packMesh/parallel/threads.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

/// Limits of a run.
struct Limits {
  /// Wall time to fit all cells in [s]; with the search for the densest packing of fewer cells (fewerCells)
  /// it may take twice as long. After that, pack() ends within 5 s, or within 2 s per 100,000 cells if that
  /// is longer. 0: no limit.
  double maxSeconds = 0.0;
  static constexpr double leastSeconds = 1e-9;  ///< of what begins at the time limit: 0 would be none
  std::int64_t maxSweeps = 100000;  ///< relaxation sweeps, or iterations of an engine, for fitting all cells
  std::int64_t sweepsForFew = 0;    ///< further sweeps if only few contacts are left then
  std::function<double()> clock = {};  ///< current time [s]; empty: the system clock
  /// If not feasible: whether to search for the densest packing of fewer cells. Otherwise pack() only reports
  /// that it did not succeed.
  bool fewerCells = true;
  /// If all cells but a few (one of twenty) keep the clearances: whether these few may keep less
  /// (Certificate::closer).
  bool someCloser = false;
};

/// Progress that pack() reports.
struct Progress {
  std::string stage;
  std::int64_t sweep = 0;
  double scale = 1.0;           ///< common scale of the cells [fraction]
  double worstOverlap = 0.0;    ///< deepest penetration into a clearance [µm]
  std::int64_t unresolved = 0;  ///< pairs that still overlap
};

struct Execution {
  /// The ranks that pack together. The packing does not depend on their number.
  Communicator communicator = {};
  Threads threads = {};  ///< of this rank; the packing does not depend on their number either
  Limits limits = {};
  /// Polled between sweeps, between the cells of a certificate, and within long operations of single ranks;
  /// true stops the run.
  std::function<bool()> interrupted = {};
  std::function<void(const Progress&)> progress = {};
  /// Called with every state that an engine accepts: this rank's cells at their current scales.
  std::function<void(const std::vector<PlacedCell>&)> observe = {};
};

}  // namespace packmesh
