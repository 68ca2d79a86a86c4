// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The parameters of growth (thesis Table 3.2, and what was added).
#pragma once

#include <vector>

namespace packmesh {

/// Defaults are ours; what the thesis uses stands in brackets.
struct GrowthSettings {
  /// Scale at which cells start, f_init [thesis: 0.1].
  double initialScale = 0.1;
  static constexpr double smallestScale = 0.001;  ///< that cells may start at
  /// Barriers b_i: no cell grows beyond one before all have reached it [0.1, 0.2, ... 1.0].
  std::vector<double> barriers = {0.3, 0.5, 0.7, 0.8, 0.9, 1.0};
  /// Iterations spent on one barrier, itn_max; the last barrier's end the attempt.
  int maxIterations = 60;

  /// Largest turn in one iteration, θ_max, about each axis [rad] [π/12].
  double rotationBound = 0.05;
  /// Largest translation in one iteration, t_max, along each axis [fraction of the cube root of the mesh's
  /// volume] [1].
  double translationBound = 0.035;
  /// Padding p [fraction of the square root of the mean area of the mesh's triangles, times the scale]
  /// [between 0 and 1]. Coarser levels are padded in proportion to the square roots of their areas.
  double padding = 0.04;
  /// How often the rotation is linearised anew in one iteration (ours).
  int linearisations = 2;

  /// Resampling, α and β of eq. 3.4 [0.05, 0.1].
  double alpha = 0.25, beta = 0.5;

  /// Whether cells at the barrier move to the middle of their planes (ours).
  bool centring = true;
  /// Largest random push, relative to growth, by which cells choose among equally good steps (ours).
  double shaking = 1e-3;

  /// Stalled: in so many iterations the mean scale of cells below the barrier grew by less than
  /// `stalledGrowth` of what was missing (ours).
  int patience = 5;
  double stalledGrowth = 0.2;
  /// When stalled, all cells take the barrier's scale and are relaxed for at most so many sweeps, more after
  /// a failure; 0: never (ours).
  int relaxationSweeps = 400;
  /// Growth ends when it stalled so often at one barrier and no relaxation helped; 0: it goes on, to the next
  /// barrier after maxIterations, as in the thesis.
  int giveUpAfter = 0;
  /// A few cells can start so that they get nowhere (a cone lying on its flank). With n cells up to attempts
  /// / n random starts are tried, all but the last one with giveUpAfter = 2 (ours).
  int attempts = 64;
};

/// @throws InputError naming the parameter that is out of its range
void validate(const GrowthSettings& settings);

}  // namespace packmesh
