// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How much of a lumen the cells of each species can reach, from a sample of its points.
#pragma once

#include <map>
#include <optional>
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
  /// Volumes in which centres can be and between which no cell can pass, as far as the resolution of the
  /// space tells, over their sum; descending. Empty where there is no wall, or one in closed form.
  std::vector<double> apart;
  std::vector<Vec3> deepest;  ///< points far from the wall, the deepest first
};

/// Made when a room is first asked for, since most packings need none, and each room once. References the
/// problem, which must outlive it.
class LumenSample {
 public:
  explicit LumenSample(const Problem& problem) : problem_(problem) {}

  /// With the demanded clearances. Only for species of which there are cells.
  const Room& room(int species);

 private:
  void draw();
  Room measured(int species) const;
  void drawFromBounds(const Box& bounds);
  void drawFrom(const AccessibleSpace& lumen);

  const Problem& problem_;
  const Wall* wall_ = nullptr;
  double volume_ = 0.0;  ///< where cells can be [µm³]; 0: not drawn yet
  std::vector<Vec3> inside_;
  std::vector<double> distances_;  ///< of them to wall_ [µm]
  std::map<int, Room> rooms_;
};

}  // namespace packmesh::hemocell
