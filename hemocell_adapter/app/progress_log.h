// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What users see while a packing is being made.
#pragma once

#include <chrono>
#include <optional>

#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/problem/scene.h"

namespace packmesh::hemocell {

/// On a terminal a line that is kept up to date, otherwise (in files, under Slurm) a plain line now and then:
/// stage, hematocrit of the cells at their present size, overlap that is left, time, and time left where the
/// forecast knows it.
/// References the scene.
class ProgressLog {
 public:
  ProgressLog(const Scene& scene, int ranks);

  void operator()(const Progress& progress);

  /// The line.
  std::string text(const Progress& progress, double seconds);

 private:
  /// By the forecast; made when it is asked for, since short packings have ended before. [s]
  std::optional<double> expectedSeconds();

  const Scene& scene_;
  int ranks_;
  double hematocrit_;  ///< of all cells at full size
  std::optional<Forecast> forecast_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  double last_ = 0.0;
};

}  // namespace packmesh::hemocell
