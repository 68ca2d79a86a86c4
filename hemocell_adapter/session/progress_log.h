// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Progress of a packing as displayed to users.
#pragma once

#include <chrono>
#include <optional>

#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/problem/problem.h"

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

}  // namespace packmesh::hemocell
