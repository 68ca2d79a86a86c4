// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What all attempts of a run share: when it stops, at a time limit or on request, and where cells can
/// be.
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>

#include "packMesh/packing/packing_problem.h"
#include "packMesh/placement/accessible_space.h"

namespace packmesh {

/// Measures the time of one run from its construction on, and polls the caller.
class RunControl {
 public:
  /// References `problem`, which must outlive it. Stops at Limits::maxSeconds unless changed by stopAfter().
  explicit RunControl(const PackingProblem& problem)
      : problem_(problem),
        start_(now()),
        end_(limited() ? problem.execution.limits.maxSeconds : unlimited),
        spare_(std::max(leastSpare, sparePerCell * static_cast<double>(problem.physics.cellCount()))),
        spaces_(problem.physics, problem.execution.threads) {}
  RunControl(const RunControl&) = delete;
  RunControl& operator=(const RunControl&) = delete;

  bool limited() const { return problem_.execution.limits.maxSeconds > 0.0; }
  double elapsed() const { return now() - start_; }  ///< on this rank [s]
  /// Sets the stop to this many seconds after the start.
  void stopAfter(double seconds) { end_ = seconds; }

  /// Whether to stop; the same on all ranks, which all call.
  bool stopped() {
    const bool stops = ends(0.0);
    if (atPolls) atPolls();
    return stops;
  }

  /// The same for this rank alone, for work that can be abandoned.
  bool stoppedHere() const { return asked() || elapsed() > end_; }

  /// Whether even the final steps after the time limit are to be abandoned: placing cells, certifying the
  /// current ones. Limits::maxSeconds states how long a run may take in total; half of that is kept for
  /// work that does not look at the clock.
  bool outOfTime() { return ends(spare_); }
  /// The same for this rank alone, for loops that ranks run independently. Once true it stays so, and
  /// outOfTime() is true on all ranks.
  bool outOfTimeHere() const { return asked() || elapsed() > end_ + spare_; }

  /// Whether one of them found that the caller requests a stop.
  bool interrupted() const { return interrupted_; }

  /// Of all attempts of the run: their cells differ in number only.
  AccessibleSpaces& spaces() { return spaces_; }

  std::function<void()> atPolls;  ///< called by stopped(); empty: nothing

 private:
  static constexpr double unlimited = std::numeric_limits<double>::infinity();

  static constexpr double leastSpare = 2.5, sparePerCell = 1e-5;  // [s]

  bool ends(double spare) {
    enum { no, late, interruption };
    const double reason = problem_.execution.communicator.max(asked()                    ? interruption
                                                              : elapsed() > end_ + spare ? late
                                                                                         : no);
    interrupted_ = interrupted_ || reason == interruption;
    return interrupted_ || reason == late;
  }
  bool asked() const { return problem_.execution.interrupted && problem_.execution.interrupted(); }
  double now() const {
    if (problem_.execution.limits.clock) return problem_.execution.limits.clock();
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }

  const PackingProblem& problem_;
  double start_, end_;  ///< by the clock; in elapsed() [s]
  double spare_;        ///< [s]
  bool interrupted_ = false;
  AccessibleSpaces spaces_;
};

}  // namespace packmesh
