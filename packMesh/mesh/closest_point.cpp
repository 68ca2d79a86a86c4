// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/closest_point.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "packMesh/core/poll.h"

namespace packmesh {
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
    facets_.emplace_back(a, mesh.vertices[corners[1]], mesh.vertices[corners[2]]);
    const Vec3 normal = facets_[t].u.cross(facets_[t].v).normalized();
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
    const Facet::Nearest on = facet.nearest(p);
    const Vec3 point = facet.at(on);
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
  const Facet::Nearest on = facet.nearest(p);
  const Vec3 point = facet.at(on);
  return {(point - p).norm(), triangle, on.feature, point};
}

int ClosestPoint::side(const Vec3& p, const Nearest& nearest) const {
  return (p - nearest.point).dot(normals_[nearest.triangle][nearest.feature]) >= 0.0 ? 1 : -1;
}

}  // namespace packmesh
