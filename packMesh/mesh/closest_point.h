// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Nearest points of a surface, and the side of the surface on which a point lies: for one point, for
/// 16 points at once, and for many.
#pragma once

#include <array>
#include <vector>

#include "packMesh/core/vector.h"
#include "packMesh/mesh/mesh_kernels.h"
#include "packMesh/mesh/mesh_tree.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// A triangle a, a + u, a + v with the products needed to compute nearest points.
struct Facet {
  Vec3 a, u, v;
  double uu, uv, vv;

  Facet(const Vec3& first, const Vec3& second, const Vec3& third)
      : a(first), u(second - first), v(third - first), uu(u.dot(u)), uv(u.dot(v)), vv(v.dot(v)) {}

  struct Nearest {
    double s, t;  ///< the point is a + s u + t v
    int feature;  ///< corner 0-2, edge 3-5 (from corner f-3 to the next), face 6
  };

  Vec3 at(const Nearest& nearest) const { return a + nearest.s * u + nearest.t * v; }

  /// Minimises |s u + t v - (p - a)|² over the triangle s, t >= 0, s + t <= 1: the unconstrained minimum if
  /// it is inside, otherwise the best minimum on the three edges.
  Nearest nearest(const Vec3& p) const;
};

inline Facet::Nearest Facet::nearest(const Vec3& p) const {
  const Vec3 w = p - a;
  const double uw = u.dot(w), vw = v.dot(w);
  const double determinant = uu * vv - uv * uv;
  const double s = vv * uw - uv * vw, t = uu * vw - uv * uw;
  if (s > 0.0 && t > 0.0 && s + t < determinant) return {s / determinant, t / determinant, 6};

  // Position along each edge, and the squared distance there minus |w|².
  Nearest best{0.0, 0.0, 0};
  double lowest = 0.0;
  const auto consider = [&](double x, double y, int feature) {
    const double value = x * x * uu + 2.0 * x * y * uv + y * y * vv - 2.0 * (x * uw + y * vw);
    if (value < lowest) {
      lowest = value;
      best = {x, y, feature};
    }
  };
  const double onU = uw / uu, onV = vw / vv;
  if (onU >= 1.0)
    consider(1.0, 0.0, 1);
  else if (onU > 0.0)
    consider(onU, 0.0, 3);
  if (onV >= 1.0)
    consider(0.0, 1.0, 2);
  else if (onV > 0.0)
    consider(0.0, onV, 5);
  // From corner u to corner v.
  const double across = (uu - uv + vw - uw) / (uu - 2.0 * uv + vv);
  if (across > 0.0 && across < 1.0) consider(1.0 - across, across, 4);
  return best;
}

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
  /// The same of a box.
  template <class Visit>
  void forEachNear(const Box& box, double distance, Visit&& visit) const {
    tree_.forEachWithin(box, distance, visit);
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

inline TriangleFacts factsOf(const TriangleMesh& mesh, int triangle) {
  TriangleFacts facts{};
  const Vec3 &a = mesh.corner(triangle, 0), &b = mesh.corner(triangle, 1), &c = mesh.corner(triangle, 2);
  const Vec3 normal = (b - a).cross(c - a).normalized();
  for (int e = 0; e < 3; ++e) {
    const Vec3& corner = mesh.corner(triangle, e);
    const Vec3 edge = mesh.corner(triangle, (e + 1) % 3) - corner, inward = normal.cross(edge);
    const double square = edge.squaredNorm();
    for (int k = 0; k < 3; ++k) {
      facts.corner[e][k] = static_cast<float>(corner[k]);
      facts.edge[e][k] = static_cast<float>(edge[k]);
      facts.inward[e][k] = static_cast<float>(inward[k]);
    }
    facts.perSquare[e] = square > 0.0 ? static_cast<float>(1.0 / square) : 0.0f;
    facts.normal[e] = static_cast<float>(normal[e]);
  }
  return facts;
}

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
  double slackAt(double distanceFromOrigin) const { return searchSlack(distanceFromOrigin + tree_.reach); }

  const MeshTree& tree_;
  const ClosestPoint& surface_;
  const TriangleKernels kernels_;
  std::vector<TriangleFacts> facts_;
};

/// A mesh for which distances are computed in blocks of points. Immutable.
class SignedDistances {
 public:
  /// @param mesh closed and oriented outwards
  explicit SignedDistances(const TriangleMesh& mesh);

  /// Signed distances (positive outside, µm) at the points (x[i], y[j], z[k]), `x` fastest, exact up to
  /// rounding to float. Neighbouring points share the search for candidate triangles, so they should be
  /// nearer to each other than to most of the surface. Pre: coordinates ascend (equal ones are permitted).
  /// @param rough points that are further from the surface than twice their spacing get a lower bound of the
  /// distance, one hundredth less at most; inside, several times the spacing away, at least three fifths of
  /// it
  void sample(const std::array<std::vector<double>, 3>& coordinates, bool rough, float* distances) const;

  const ClosestPoint& surface() const { return surface_; }

 private:
  class Search;

  ClosestPoint surface_;
  std::vector<TriangleFacts> facts_;  ///< of all triangles; the corners are set during a search
  std::vector<TriangleDisc> discs_;   ///< around all triangles
  TriangleKernels kernels_;
};

}  // namespace packmesh
