// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The attempts to pack one problem, by its plan (plan.h), with progress, states and interruptions.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "hemocell_adapter/output/packing.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/problem/plan.h"
#include "hemocell_adapter/problem/problem.h"
#include "packMesh/core/timer.h"

namespace packmesh::hemocell {

/// On a terminal a line that is updated in place, otherwise (in files, under Slurm) a plain line at
/// intervals: stage, hematocrit of the cells at their current size, remaining overlap, elapsed time, and
/// remaining time if there is a forecast. References the problem and a sample of its lumen.
class ProgressLog {
 public:
  ProgressLog(const Problem& problem, LumenSample& sample);

  void operator()(const Progress& progress);

  /// Since packing began [s].
  double seconds() const;
  /// Time that is left [s], if there is a forecast. Nothing in the first second: short packings end before.
  std::optional<double> remaining(double seconds);
  /// The line.
  std::string text(const Progress& progress, double seconds);

 private:
  /// From the forecast, which is computed on demand, since short packings end before. [s]
  std::optional<double> expectedSeconds();

  const Problem& problem_;
  LumenSample& sample_;
  double hematocrit_;  ///< of all cells at full size
  std::optional<Forecast> forecast_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  double last_ = 0.0;
};

/// What a packing asks and tells while it runs; empty: never interrupted, a ProgressLog.
struct Hooks {
  std::function<bool()> interrupted;
  std::function<void(const Progress&, ProgressLog&)> progress;
  void tell(const Progress& now, ProgressLog& log) const { progress ? progress(now, log) : log(now); }
  bool convertsFrames = true;  ///< false: the caller makes series of the states of the engine (StateFrames)
};

/// The attempts of one run. References its arguments. All ranks call everything together.
class Ladder {
 public:
  /// @param sample of the lumen @param timer since packing began
  Ladder(std::shared_ptr<const Problem> problem, const OutputRequest& output, LumenSample& sample,
         const Hooks& hooks, const Timer& timer);

  /// Tries the rungs of the plan until one succeeds; then, if that is asked for, larger clearances until the
  /// time limit or convergence. Deterministic except for time limits. The cells are not counted yet.
  /// @return if out of reach, fewer cells, or what the last attempt reached; Packing::whyFewer says why cells
  /// could not be soft
  /// @throws InputError, AgreedFailure
  Packing climb();

  /// One attempt.
  /// @param seconds that it may take; 0: no limit
  /// @return nothing if its clearances are impossible and fewer cells are not requested. A probe has no cells
  std::optional<Packing> attempt(const Rung& rung, double seconds = 0.0);

  /// Whether the last checkpoint has been written; whether there is one of this run.
  bool saved() const { return saved_; }
  bool savedAny() const { return savedAny_; }

 private:
  Begin findBegin() const;
  std::size_t firstRung(const Plan& plan);
  PartsToPack partsOf(const Rung& rung) const;
  PackingProblem packingProblem(const Rung& rung, const PartsToPack& parts);
  void start(PackingProblem& packing);
  Packing probed(PackingProblem& packing, const PartsToPack& parts);
  PackingResult packWithFrames(PackingProblem& packing) const;
  void interrupt(Packing& packed, bool savesStates);
  void explain(const Rung& rung, Packing& packed);
  void warnOfDeformed(const Rung& rung, const PartsToPack& parts, const std::vector<Cell>& cells) const;
  void widen(Packing& best);
  void finish(const Packing& packing) const;
  Packing nothing(Outcome outcome) const;
  void note(const StateFiles& states);
  bool isInterrupted() const { return ranks().any(hooks_.interrupted && hooks_.interrupted()); }
  const Communicator& ranks() const { return problem_->ranks; }
  double elapsed() const { return ranks().max(timer_.wall()); }

  const std::shared_ptr<const Problem> problem_;
  const OutputRequest& output_;
  LumenSample& sample_;
  const Hooks& hooks_;
  const Timer& timer_;
  ProgressLog progress_;
  Begin begin_;
  bool begun_ = false, saved_ = false, savedAny_ = false;
  std::string whyNotWithRoom_;  ///< of soft cells; empty if that was not tried, as in a run that is continued
  std::string whyNotDeformed_;  ///< of the last attempt; empty if it succeeded, or there was none
  std::string raise_;           ///< see Packing::raise
};

}  // namespace packmesh::hemocell
