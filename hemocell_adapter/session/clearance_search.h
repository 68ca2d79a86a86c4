// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Packing of one problem with a sequence of clearances, with progress, states and interruptions.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "hemocell_adapter/output/packing.h"
#include "hemocell_adapter/problem/clearances.h"
#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/problem/problem.h"
#include "packMesh/core/timer.h"

namespace packmesh::hemocell {

/// On a terminal a line that is updated in place, otherwise (in files, under Slurm) a plain line at
/// intervals: stage, hematocrit of the cells at their current size, remaining overlap, elapsed time, and
/// remaining time if there is a forecast. References the problem and a sample of its lumen.
class ProgressLog {
 public:
  ProgressLog(const Problem& problem, LumenSample& sample) : ProgressLog(problem, sample, problem.request) {}
  ProgressLog(const Problem& problem, LumenSample& sample, const SearchLimits& limits);

  void operator()(const Progress& progress);

  /// Since packing began [s].
  double seconds() const;
  /// Time that is left [s], if there is a forecast, or by what is left of the sweeps and how long those since
  /// the first call took. Nothing in the first second: short packings end before.
  std::optional<double> remaining(const Progress& progress, double seconds);
  /// The line.
  std::string text(const Progress& progress, double seconds);

 private:
  /// From the forecast, which is computed on demand, since short packings end before. [s]
  std::optional<double> expectedSeconds();

  const Problem& problem_;
  LumenSample& sample_;
  SearchLimits limits_;
  double hematocrit_;  ///< of all cells at full size
  std::optional<Forecast> forecast_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  double last_ = 0.0;
  std::int64_t firstSweep_ = -1, lastSweep_ = -1;  ///< told of those that are counted (Progress::left)
  double firstSeconds_ = 0.0;
};

/// What a packing asks and tells while it runs; empty: never interrupted, a ProgressLog.
struct Hooks {
  std::function<bool()> interrupted;
  std::function<void(const Progress&, ProgressLog&)> progress;
  void tell(const Progress& now, ProgressLog& log) const { progress ? progress(now, log) : log(now); }
  bool convertsFrames = true;  ///< false: the caller makes series of the states of the engine (StateFrames)
};

/// References its arguments. All ranks call everything together.
class ClearanceSearch {
 public:
  /// @param sample of the lumen, for estimates of the time that is left
  /// @param limits empty: those of the request
  /// @param isContinued whether the first attempt continues from the state of `restart`, and states are saved
  /// for that; otherwise only that of the result is kept
  ClearanceSearch(std::shared_ptr<const Problem> problem, const OutputRequest& output, LumenSample& sample,
                  const Hooks& hooks = {}, const std::optional<SearchLimits>& limits = {},
                  bool isContinued = true);

  /// @return nothing if the clearances are impossible and fewer cells are not requested
  /// @throws InputError, AgreedFailure
  std::optional<PackingResult> packAt(const Clearances& clearances, const AttemptLimits& limits);

  /// Packs with the widest clearances that are found quickly, as packWithClearances() does, and reports
  /// effort and clearances unless interrupted. Its cells are not counted yet. @param timer since packing
  /// began
  Packing withClearances(const Timer& timer);

  /// The level to which the state of `restart` belongs; 0 without one, the last if it belongs to none.
  std::size_t firstLevel(const std::vector<Clearances>& levels);

  /// Whether the last checkpoint has been written; whether there is one of this run.
  bool saved() const { return saved_; }
  bool savedAny() const { return savedAny_; }

 private:
  const PartsToPack& partsWith(const Clearances& clearances);
  bool isInterrupted() const { return hooks_.interrupted && hooks_.interrupted(); }

  const std::shared_ptr<const Problem> shared_;
  const Problem& problem_;
  const OutputRequest& output_;
  const SearchLimits limits_;
  ProgressLog progress_;
  Hooks hooks_;
  const bool isContinued_;
  PartsToPack last_;                 ///< of the last attempt
  std::optional<PackingState> end_;  ///< of the last attempt that had a result
  bool begun_ = false, saved_ = false, savedAny_ = false;
};

}  // namespace packmesh::hemocell
