// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Forecast of the time and memory of a packing.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/problem.h"
#include "packMesh/placement/accessible_space.h"

namespace packmesh::hemocell {

/// The part of a lumen that is available to bodies of a species.
struct Room {
  double share = 1.0;      ///< fraction of the lumen
  double volume = 0.0;     ///< the same [µm³]; includes continuations of the ends of a vessel
  double effective = 0.0;  ///< the same without a layer at the wall, in which packings are less dense [µm³]
  /// The widest place that is wide enough for a body, but that no cell can enter.
  struct Narrow {
    Vec3 at;
    double width;  ///< [µm]
  };
  std::optional<Narrow> narrow;
  std::vector<Vec3> deepest;  ///< points far from the wall, the deepest first
};

/// Made when a room is first asked for, since most packings need none, and each room once. References the
/// problem, which must outlive it.
class LumenSample {
 public:
  explicit LumenSample(const Problem& problem) : problem_(problem) {}

  /// With the demanded clearances. Only for species of which there are cells.
  const Room& room(int species);
  /// Volumes in which centres can be and between which no cell can pass, as far as the resolution of the
  /// space tells, over their sum; descending. Empty where there is no wall, or one in closed form.
  const std::vector<double>& apart(int species);
  /// Of the lumen at its widest place, between walls or periodic images [µm].
  double width();

 private:
  void draw();
  Room measured(int species);
  void drawFromBounds(const Box& bounds);
  void drawFrom(const AccessibleSpace& cover);

  const Problem& problem_;
  const Wall* wall_ = nullptr;
  double volume_ = 0.0;  ///< where cells can be [µm³]; 0: not drawn yet
  std::vector<Vec3> inside_;
  std::vector<double> distances_;    ///< of them to wall_ [µm]; those far from it by interpolation
  double interpolationError_ = 0.0;  ///< distances are less by this at most, in the middle of a lumen [µm]
  std::map<int, Room> rooms_;
  std::map<int, std::unique_ptr<const AccessibleSpace>> spaces_;  ///< of the rooms, unless apart() is known
  std::map<int, std::vector<double>> apart_;
};

/// Estimates calibrated on measurements (docs/explanation/forecast.md).
struct Forecast {
  std::int64_t cells = 0;
  double fraction = 0.0;  ///< volume of all meshes over that of the lumen
  /// The volume fraction at which packing a periodic box is equally hard: clearances are added to the cells,
  /// and each species has the part of the lumen in which its bodies can be, minus a layer at its wall. Cells
  /// that exist with shapes of their own are room that others lack. With a profile at least that of its
  /// densest shell. Infinite if nothing remains.
  double effectiveFraction = 0.0;
  std::vector<double> roomShares;   ///< of the lumen, where bodies of each species may be
  std::vector<double> roomVolumes;  ///< the same [µm³]; includes continuations of the ends of a vessel
  std::optional<double> seconds;    ///< CPU of one core; empty beyond `possible`
  /// The lumen is hardly wider than the cells that fill most of it: walls order them, which may let more or
  /// fewer fit.
  bool narrow = false;
  double megabytes = 0.0;          ///< of all ranks together, of undeformed cells
  double deformedMegabytes = 0.0;  ///< the same if cells deform

  /// Up to `easy` a packing of red cells takes hundreds of sweeps; above `possible` no packing of a thousand
  /// cells at random has been achieved.
  static constexpr double easy = 0.60, possible = 0.62;
  /// In narrow lumens packings have failed from `doubtful` on, and have been found up to `ordered`; a hundred
  /// cells at most in wider ones up to `possibleForFew`.
  static constexpr double doubtful = 0.50, ordered = 0.91, possibleForFew = 0.72;
  static constexpr std::int64_t few = 100;
};

/// Of the default method.
Forecast forecastOf(const Problem& problem, LumenSample& sample);
inline Forecast forecastOf(const Problem& problem) {
  LumenSample sample(problem);
  return forecastOf(problem, sample);
}

/// "The request: 108 cells with 0.47 of the lumen's volume, ...": what makes a packing hard, for messages.
std::string roomText(const Problem& problem, const Forecast& forecast, LumenSample& sample);

/// What the first lines of a run say of a vessel or of fluid nodes: how much of it red cells can reach, and
/// whether that is enough. Nothing for shapes in closed form.
std::vector<std::string> reachLines(const Problem& problem, LumenSample& sample);

/// What `--dry-run` prints.
struct ForecastText {
  std::vector<std::string> lines;
  bool impossible = false;        ///< no method can pack all cells
  std::optional<double> seconds;  ///< Forecast::seconds
  double megabytes = 0.0;         ///< of all ranks together
};
ForecastText forecastText(const Problem& problem, int ranks);

}  // namespace packmesh::hemocell
