// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/closest_point.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "packMesh/core/poll.h"

namespace packmesh {
namespace {

struct OnTriangle {
  double s, t;  ///< the point is a + s u + t v
  int feature;
};

/// Minimises |s u + t v - w|² over the triangle s, t >= 0, s + t <= 1: the unconstrained minimum if it is
/// inside, otherwise the best minimum on the three edges.
template <class Facet>
OnTriangle nearestOnTriangle(const Facet& f, const Vec3& w) {
  const double uw = f.u.dot(w), vw = f.v.dot(w);
  const double determinant = f.uu * f.vv - f.uv * f.uv;
  const double s = f.vv * uw - f.uv * vw, t = f.uu * vw - f.uv * uw;
  if (s > 0.0 && t > 0.0 && s + t < determinant) return {s / determinant, t / determinant, 6};

  // Position along each edge, and the squared distance there minus |w|².
  OnTriangle best{0.0, 0.0, 0};
  double lowest = 0.0;
  const auto consider = [&](double x, double y, int feature) {
    const double value = x * x * f.uu + 2.0 * x * y * f.uv + y * y * f.vv - 2.0 * (x * uw + y * vw);
    if (value < lowest) {
      lowest = value;
      best = {x, y, feature};
    }
  };
  const double onU = uw / f.uu, onV = vw / f.vv;
  if (onU >= 1.0)
    consider(1.0, 0.0, 1);
  else if (onU > 0.0)
    consider(onU, 0.0, 3);
  if (onV >= 1.0)
    consider(0.0, 1.0, 2);
  else if (onV > 0.0)
    consider(0.0, onV, 5);
  // From corner u to corner v.
  const double across = (f.uu - f.uv + vw - uw) / (f.uu - 2.0 * f.uv + f.vv);
  if (across > 0.0 && across < 1.0) consider(1.0 - across, across, 4);
  return best;
}

}  // namespace

ClosestPoint::ClosestPoint(const TriangleMesh& mesh) : tree_(mesh) {
  const std::size_t n = mesh.triangles.size();
  facets_.reserve(n);
  normals_.resize(n);
  struct Side {
    int lo, hi, triangle, edge;
  };
  std::vector<Side> sides;
  std::vector<Vec3> atVertex(mesh.vertices.size(), Vec3::Zero());
  for (std::size_t t = 0; t < n; ++t) {
    pollAt(t);
    const Triangle& corners = mesh.triangles[t];
    const Vec3& a = mesh.vertices[corners[0]];
    const Vec3 u = mesh.vertices[corners[1]] - a, v = mesh.vertices[corners[2]] - a;
    facets_.push_back({a, u, v, u.dot(u), u.dot(v), v.dot(v)});
    const Vec3 normal = u.cross(v).normalized();
    normals_[t][6] = normal;
    for (int k = 0; k < 3; ++k) {
      const int here = corners[k], next = corners[(k + 1) % 3], previous = corners[(k + 2) % 3];
      const Vec3 out = mesh.vertices[next] - mesh.vertices[here],
                 back = mesh.vertices[previous] - mesh.vertices[here];
      atVertex[here] += std::atan2(out.cross(back).norm(), out.dot(back)) * normal;
      sides.push_back({std::min(here, next), std::max(here, next), static_cast<int>(t), k});
    }
  }
  for (std::size_t t = 0; t < n; ++t)
    for (int k = 0; k < 3; ++k) normals_[t][k] = atVertex[mesh.triangles[t][k]];
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.lo != b.lo ? a.lo < b.lo : a.hi != b.hi ? a.hi < b.hi : a.triangle < b.triangle;
  });
  for (std::size_t from = 0, to = 0; from < sides.size(); from = to) {
    Vec3 sum = Vec3::Zero();
    for (to = from; to < sides.size() && sides[to].lo == sides[from].lo && sides[to].hi == sides[from].hi;
         ++to)
      sum += normals_[sides[to].triangle][6];
    for (std::size_t s = from; s < to; ++s) normals_[sides[s].triangle][3 + sides[s].edge] = sum;
  }
}

ClosestPoint::Nearest ClosestPoint::nearest(const Vec3& p, int hint, double slack) const {
  Nearest best{0.0, -1, 6, p};
  double squared = std::numeric_limits<double>::infinity();
  const double enough = 1.0 / ((1.0 + slack) * (1.0 + slack));
  const auto visit = [&](int t) {
    const Facet& facet = facets_[t];
    const OnTriangle on = nearestOnTriangle(facet, p - facet.a);
    const Vec3 point = facet.a + on.s * facet.u + on.t * facet.v;
    const double d2 = (point - p).squaredNorm();
    if (d2 < squared) {
      squared = d2;
      best.triangle = t;
      best.feature = on.feature;
      best.point = point;
    }
    return squared * enough;
  };
  double bound = std::numeric_limits<double>::infinity();
  if (hint >= 0) bound = visit(hint);
  tree_.visitNearer(p, bound, visit);
  best.distance = std::sqrt(squared);
  return best;
}

ClosestPoint::Nearest ClosestPoint::onTriangle(int triangle, const Vec3& p) const {
  const Facet& facet = facets_[triangle];
  const OnTriangle on = nearestOnTriangle(facet, p - facet.a);
  const Vec3 point = facet.a + on.s * facet.u + on.t * facet.v;
  return {(point - p).norm(), triangle, on.feature, point};
}

int ClosestPoint::side(const Vec3& p, const Nearest& nearest) const {
  return (p - nearest.point).dot(normals_[nearest.triangle][nearest.feature]) >= 0.0 ? 1 : -1;
}

}  // namespace packmesh
