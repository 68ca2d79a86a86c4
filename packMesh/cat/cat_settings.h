// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The settings of growth and escapes.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace packmesh {

/// Construction of the planes within which cells grow.
enum class PlaneSource {
  chords,  ///< shortest chords between neighbours, from distance fields
  /// CAT faces of tetrahedra, as in the thesis. Digests of problems contain the number; 1 was another source.
  catFaces = 2,
};

/// The values of the thesis are in brackets.
struct GrowthSettings {
  /// Initial scale of the cells, f_init [thesis: 0.1].
  double initialScale = 0.1;
  static constexpr double smallestScale = 0.001;  ///< smallest valid initial scale
  /// Barriers b_i: no cell grows beyond one before all have reached it [0.1, 0.2, ... 1.0].
  std::vector<double> barriers = {0.5, 0.7, 0.8, 0.9, 0.95, 1.0};
  /// Maximum number of iterations per barrier, itn_max; at the last barrier, the attempt ends.
  int maxIterations = 60;

  /// Largest rotation in one iteration, θ_max, about each axis [rad] [π/12].
  double rotationBound = 0.05;
  /// Largest translation in one iteration, t_max, along each axis [fraction of the cube root of the mesh's
  /// volume] [1].
  double translationBound = 0.035;
  /// Padding p [fraction of the square root of the mean area of the mesh's triangles, times the scale]
  /// [between 0 and 1]. On coarser levels, it is scaled with the square root of the mean area.
  double padding = 0.04;
  /// Number of linearisations of the rotation in one iteration (not in the thesis).
  int linearisations = 1;

  /// Resampling, α and β of eq. 3.4 [0.05, 0.1].
  double alpha = 0.25, beta = 0.5;

  /// Whether cells at the barrier move to the middle of their planes (not in the thesis).
  bool centring = true;
  /// Magnitude of the random push, relative to growth, that selects one of several equally good steps (not in
  /// the thesis).
  double shaking = 1e-3;

  /// Growth has stalled if within this many iterations the mean scale of the cells below the barrier
  /// increased by less than `stalledGrowth` of the deficit (not in the thesis).
  int patience = 5;
  double stalledGrowth = 0.45;
  /// On a stall, and after maxIterations, all cells are set to the barrier's scale and relaxed for at most
  /// this many sweeps, more after a failure; 0: never (not in the thesis).
  int relaxationSweeps = 400;
  /// Growth ends after this many stalls at one barrier if no relaxation helped; 0: it continues, to the next
  /// barrier after maxIterations, as in the thesis.
  int giveUpAfter = 0;
  /// A few cells can start in poses from which they cannot reach full size (a cone lying on its flank). With
  /// n cells, up to attempts / n random starts are tried, all but the last one with giveUpAfter = 2 (not in
  /// the thesis).
  int attempts = 64;
};

/// @throws InputError naming the parameter that is out of its range
void validate(const GrowthSettings& settings);

/// Numbers per block do not depend on the number of ranks: blocks are at least four largest radii wide, and
/// a container in which no two such blocks fit side by side is one block.
struct EscapeSettings {
  int orientations = 3;               ///< number of random orientations tried in each room
  int swapRounds = 6;                 ///< largest number of groups of cells, per block, that exchange places
  int groupSize = 12;                 ///< number of cells in a group
  int holes = 60;                     ///< number of holes tried per block, largest first
  std::vector<std::int64_t> reserve;  ///< per species: number of bodies that can be added; empty: none
};

struct CatSettings {
  PlaneSource planeSource = PlaneSource::chords;
  GrowthSettings growth = {};
  /// If growth does not bring all cells to full size, and if there is a reserve, escape from local maxima.
  std::optional<EscapeSettings> escape = {};

  bool usesReserve() const { return escape.has_value(); }
};

}  // namespace packmesh
