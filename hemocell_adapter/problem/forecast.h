// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What a packing will take, before it is made.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/scene.h"

namespace packmesh::hemocell {

/// Estimates calibrated on measurements (docs/explanation/forecast.md).
struct Forecast {
  std::int64_t cells = 0;
  double fraction = 0.0;  ///< volume of all meshes over that of the lumen
  /// The fraction at which a periodic box is as hard to pack: clearances are added to the cells, and each
  /// species has the part of the lumen in which its bodies may be, less a layer at its wall. Infinite when
  /// that leaves nothing.
  double effectiveFraction = 0.0;
  std::vector<double> roomShares;  ///< of the lumen, where bodies of each species may be
  std::optional<double> seconds;   ///< CPU of one core; empty beyond `possible`
  double megabytes = 0.0;          ///< of all ranks together

  /// Up to here a packing of red cells takes hundreds of sweeps, above `possible` none of a thousand at
  /// random was ever made.
  static constexpr double easy = 0.60, possible = 0.61;
};

/// Of the default method.
Forecast forecastOf(const Scene& scene);

/// What `--dry-run` says.
std::vector<std::string> forecastLines(const Scene& scene, int ranks);

}  // namespace packmesh::hemocell
