// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Convex hull of a mesh, its support function, and the separation of two hulls.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Convex hull of the vertices of a mesh, for one query: which vertex is furthest in a given direction?
class ConvexHull {
 public:
  ConvexHull() = default;  ///< of no points
  explicit ConvexHull(const TriangleMesh& mesh);

  /// The hull's vertices [µm].
  const std::vector<Vec3>& points() const { return points_; }

  /// Index into points() of a point furthest along `direction` (not zero), up to a rounding error of 1e-11 of
  /// the hull's size.
  int furthest(const Vec3& direction) const {
    int best = starts_[startCell(direction)];
    double value = direction.dot(points_[best]);
    // On a convex polytope, a vertex that is not exceeded by any neighbour is the maximum.
    for (int at = -1; at != best;) {
      at = best;
      for (int n = firstNeighbor_[at]; n < firstNeighbor_[at + 1]; ++n) {
        const double other = direction.dot(points_[neighbors_[n]]);
        if (other > value) {
          value = other;
          best = neighbors_[n];
        }
      }
    }
    return best;
  }

 private:
  /// Cells per side of a cube of directions; a search starts at the result for the centre of the direction's
  /// cell.
  static constexpr int cells = 8;
  static int startCell(const Vec3& direction);

  std::vector<Vec3> points_;
  std::vector<int> firstNeighbor_, neighbors_;  ///< vertices joined to vertex i by an edge
  std::array<int, 6 * cells * cells> starts_{};
};

inline int ConvexHull::startCell(const Vec3& direction) {
  const double x = std::abs(direction[0]), y = std::abs(direction[1]), z = std::abs(direction[2]);
  const int axis = x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2);
  const int k = axis == 2 ? 0 : axis + 1, l = axis == 0 ? 2 : axis - 1;
  const double scale = 0.5 * cells / std::abs(direction[axis]);
  const int u = std::min(cells - 1, static_cast<int>(0.5 * cells + scale * direction[k]));
  const int v = std::min(cells - 1, static_cast<int>(0.5 * cells + scale * direction[l]));
  return ((2 * axis + (direction[axis] < 0.0)) * cells + u) * cells + v;
}

/// Tries to prove that `first` and `second`, mapped into the frame of `first` by x -> linear·x + translation,
/// are more than `distance` apart. false: they are not, or the test was inconclusive.
///
/// Method: E. Gilbert, D. Johnson, S. Keerthi, "A fast procedure for computing the distance between complex
/// objects in three-dimensional space", IEEE J. Robotics Automation 4 (1988). Every direction tried gives a
/// valid lower bound of the distance, so no step needs to be exact.
/// @param direction initial direction, from the second to the first; not zero
/// @param rounding upper bound of the rounding error of distances in the frame of `first` (coordinates and
/// supports)
bool hullsApart(const ConvexHull& first, const ConvexHull& second, const Mat3& linear,
                const Vec3& translation, const Vec3& direction, double distance, double rounding);

}  // namespace packmesh
