// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Search for nearest triangles through the discs of a mesh's tree, for 16 points at once.
#pragma once

#include <array>
#include <vector>

#include "packMesh/mesh/closest_point.h"
#include "packMesh/mesh/mesh_tree.h"
#include "packMesh/mesh/triangle_kernel.h"

namespace packmesh {

/// The same distances as ClosestPoint::nearest(), for meshes near the origin of their frame. Points that are
/// near each other are searched together, and discs bound a part of a smooth surface more closely than boxes:
/// far fewer triangles are tested where many are about as far away, as from inside a round cell. Immutable;
/// references both arguments of the constructor.
class DiscSearch {
 public:
  static constexpr int points = 16;

  /// Pre: both are of the same mesh
  DiscSearch(const MeshTree& tree, const ClosestPoint& surface);

  /// Points and their nearest triangles.
  struct Query {
    std::array<Vec3, points> point;
    std::array<double, points> atMost;  ///< upper bound of the distance [µm]; negative: the point is left out
    std::array<ClosestPoint::Nearest, points> nearest;  ///< of several at the same distance any
  };
  /// Sets `nearest`.
  void search(Query& query) const;

  /// Whether it is efficient to tell apart distances of `length` [µm] from points up to twice as far from the
  /// origin as the mesh: discs are stored in floats.
  bool resolves(double length) const { return slackAt(2.0 * tree_.reach) < length * length; }

 private:
  /// Distances d from triangles have errors e of up to 16 roundings of floats of the size of the coordinates:
  /// twice the error of d², 4 d e + 2 e², is less than searchGrowth d² + this [µm²].
  double slackAt(double distanceFromOrigin) const {
    constexpr double sixteenRoundings = 1e-6;
    const double error = sixteenRoundings * (distanceFromOrigin + tree_.reach);
    return (4.0 / searchGrowth + 2.0) * error * error;
  }

  const MeshTree& tree_;
  const ClosestPoint& surface_;
  const TriangleKernels kernels_;
  std::vector<TriangleFacts> facts_;
};

}  // namespace packmesh
