// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Engines: what brings cells to full size without overlap, in place of placement and relaxation; and
/// RunControl, which ends runs.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/placement/accessible_space.h"

namespace packmesh {

/// What all attempts of a run share: when it stops, at a time limit or on request, and where cells can be.
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
  bool stoppedHere() const { return stopRequested() || elapsed() > end_; }

  /// Whether even the final steps after the time limit are to be abandoned: placing cells, certifying the
  /// current ones. Limits::maxSeconds states how long a run may take in total; half of that is kept for
  /// work that does not look at the clock.
  bool outOfTime() { return ends(spare_); }
  /// The same for this rank alone, for loops that ranks run independently. Once true it stays so, and
  /// outOfTime() is true on all ranks.
  bool outOfTimeHere() const { return stopRequested() || elapsed() > end_ + spare_; }

  /// Whether one of them found that the caller requests a stop, or that the time is over.
  bool interrupted() const { return interrupted_; }
  bool late() const { return late_; }

  /// Of all attempts of the run: their cells differ in number only.
  AccessibleSpaces& spaces() { return spaces_; }

  std::function<void()> atPolls;  ///< called by stopped(); empty: nothing

 private:
  static constexpr double unlimited = std::numeric_limits<double>::infinity();

  static constexpr double leastSpare = 2.5, sparePerCell = 1e-5;  // [s]

  bool ends(double spare) {
    enum { nothing, timeLimit, interruption };
    const double reason = problem_.execution.communicator.max(stopRequested()            ? interruption
                                                              : elapsed() > end_ + spare ? timeLimit
                                                                                         : nothing);
    interrupted_ = interrupted_ || reason == interruption;
    late_ = late_ || reason == timeLimit;
    return interrupted_ || reason == timeLimit;
  }
  bool stopRequested() const { return problem_.execution.interrupted && problem_.execution.interrupted(); }
  double now() const {
    if (problem_.execution.limits.clock) return problem_.execution.limits.clock();
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }

  const PackingProblem& problem_;
  double start_, end_;  ///< by the clock; in elapsed() [s]
  double spare_;        ///< [s]
  bool interrupted_ = false, late_ = false;
  AccessibleSpaces spaces_;
};

class Digest;
class Hdf5Reader;

/// What an engine has brought to full size.
struct EngineCells {
  std::vector<Body> cells;  ///< of this rank, with any ids
  /// Of an engine that deforms cells, in place of these: the physics in which all have their places, as they
  /// will be written, on all ranks. They may be fewer than requested.
  std::optional<Physics> deformed;
};

/// The stage of an attempt in which an engine works, from placement to the first certificate. All ranks call
/// its functions together.
class EngineStage {
 public:
  virtual ~EngineStage() = default;

  /// Continues until the requested cells are of full size, the stage has ended or is stopped, or the given
  /// number of iterations is done. @return whether they are
  virtual bool run(std::int64_t iterations) = 0;

  /// Whether it has ended, so that more iterations change nothing.
  virtual bool ended() const = 0;
  /// Whether there are cells.
  virtual bool hasBegun() const = 0;
  virtual std::int64_t iterations() const = 0;

  /// This rank's cells in their current state.
  virtual std::vector<Body> cells() const = 0;
  /// Everything needed to resume from here, apart from the cells.
  virtual std::shared_ptr<const EngineState> save() const = 0;
  /// The cells of full size in the best state so far; completes the statistics.
  virtual EngineCells take() = 0;
};

/// An engine with its settings.
class Engine {
 public:
  virtual ~Engine() = default;

  /// The number and the name of its stage in states.
  struct StageInFiles {
    std::int32_t number;
    const char* name;
  };
  virtual StageInFiles stage() const = 0;
  /// The state of a file at that stage, and what it has of the cells. Every rank calls it on its own.
  /// @param cells of this rank, in their order @param first number of the first one in the file
  /// @throws InputError
  virtual std::shared_ptr<const EngineState> readState(const Hdf5Reader& in, const PackingProblem& problem,
                                                       std::int64_t first,
                                                       std::vector<BodyState>& cells) const = 0;

  /// Whether its cells get meshes of their own. Then those of full size need not fit as they are, the engine
  /// itself packs fewer of them if Limits::fewerCells asks for that, and its states tell themselves apart.
  virtual bool deforms() const { return false; }
  /// @throws InputError if the problem cannot be packed with these settings
  virtual void validate(const PackingProblem& problem) const = 0;
  /// Adds what states of problems with different settings are told apart by.
  virtual void addTo(Digest& digest) const = 0;
  /// Statistics of a run that has done so many iterations.
  virtual std::shared_ptr<EngineStatistics> statistics(std::int64_t iterations) const = 0;

  /// Continues from PackingProblem::resume if that is a state of the engine. References its arguments, which
  /// must outlive the stage.
  /// @param statistics are added to
  /// @param keep called at intervals, when the state can be saved
  virtual std::unique_ptr<EngineStage> begin(const PackingProblem& problem, RunControl& control,
                                             Statistics& statistics, std::function<void()> keep) const = 0;

  /// The engine for trials in the search for the densest packing of fewer cells; none if it deforms them.
  virtual std::shared_ptr<const Engine> forTrials() const { return nullptr; }
  /// Whether its result can be denser than what that search finds.
  virtual bool canExceedTrials() const { return false; }
};

}  // namespace packmesh
