// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Nearest point of a surface, and the side of the surface on which a point lies.
#pragma once

#include <array>
#include <vector>

#include "packMesh/mesh/facet.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/mesh/triangle_tree.h"

namespace packmesh {

/// Nearest-point queries on a mesh. Immutable.
class ClosestPoint {
 public:
  explicit ClosestPoint(const TriangleMesh& mesh);

  struct Nearest {
    double distance;  ///< [µm], >= 0
    int triangle;
    int feature;  ///< of the triangle: corner 0-2, edge 3-5 (from corner f-3 to the next), face 6
    Vec3 point;   ///< [µm]
  };

  /// The nearest point of the surface.
  /// @param hint a triangle that is probably near; -1: none
  /// @param slack the result can be up to 1 + slack times as far away as the nearest point
  Nearest nearest(const Vec3& p, int hint = -1, double slack = 0.0) const;

  /// +1 outside, -1 inside, for a point and its `nearest` (computed without slack).
  ///
  /// Uses the angle-weighted pseudonormal of the feature that contains the nearest point: J. A. Baerentzen
  /// and H. Aanaes, IEEE Trans. Vis. Comput. Graph. 11(3), 2005. Pre: mesh closed and oriented outwards.
  int side(const Vec3& p, const Nearest& nearest) const;

  /// Calls `visit(t)` for every triangle whose bounding box is nearer to `p` than `distance` [µm], until
  /// `visit` returns false.
  template <class Visit>
  void forEachNear(const Vec3& p, double distance, Visit&& visit) const {
    tree_.visitNearer(p, distance * distance, [&](int t) { return visit(t) ? distance * distance : -1.0; });
  }

  /// Unit pseudonormal at the nearest point.
  Vec3 normal(const Nearest& nearest) const {
    return normals_[nearest.triangle][nearest.feature].normalized();
  }

  /// The nearest point of one triangle.
  Nearest onTriangle(int triangle, const Vec3& p) const;

  Vec3 corner(int triangle, int k) const {
    const Facet& f = facets_[triangle];
    return k == 0 ? f.a : f.a + (k == 1 ? f.u : f.v);
  }

  /// Positive outside [µm].
  double signedDistance(const Vec3& p) const {
    const Nearest found = nearest(p);
    return side(p, found) * found.distance;
  }

 private:
  TriangleTree tree_;
  std::vector<Facet> facets_;
  std::vector<std::array<Vec3, 7>> normals_;  ///< pseudonormals of corners, edges, face of each triangle
};

}  // namespace packmesh
