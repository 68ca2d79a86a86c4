// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/shape/sample_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "packMesh/core/box.h"
#include "packMesh/core/poll.h"

namespace packmesh {
namespace {

int divisions(const Vec3& a, const Vec3& b, double spacing) {
  return std::max(1, static_cast<int>(std::ceil((b - a).norm() / spacing)));
}

/// Pre: closed and consistently oriented, so that each edge is traversed once in either direction
std::vector<Vec3> pointsOn(const TriangleMesh& mesh, double spacing) {
  std::vector<Vec3> points = mesh.vertices;
  for (const Triangle& t : mesh.triangles) {
    int most = 1;
    for (int k = 0; k < 3; ++k) {
      const int a = std::min(t[k], t[(k + 1) % 3]), b = std::max(t[k], t[(k + 1) % 3]);
      const int n = divisions(mesh.vertices[a], mesh.vertices[b], spacing);
      most = std::max(most, n);
      if (t[k] != a) continue;
      for (int i = 1; i < n; ++i)
        points.push_back(mesh.vertices[a] + (mesh.vertices[b] - mesh.vertices[a]) * (double(i) / n));
    }
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    for (int i = 1; i < most; ++i)
      for (int j = 1; i + j < most; ++j)
        points.push_back(a + (b - a) * (double(i) / most) + (c - a) * (double(j) / most));
  }
  return points;
}

/// Divides [first, last) along its longest axis into the fewest clusters that can hold it, with sizes that
/// differ by at most one point, so that padding gives no point much more weight than others.
void cluster(std::vector<Vec3>::iterator first, std::vector<Vec3>::iterator last, SamplePoints& out) {
  const auto count = last - first;
  poll();
  if (count <= SamplePoints::width) {
    for (int k = 0; k < SamplePoints::width; ++k) {
      const Vec3& p = first[k % count];
      out.x.push_back(static_cast<float>(p.x()));
      out.y.push_back(static_cast<float>(p.y()));
      out.z.push_back(static_cast<float>(p.z()));
    }
    Box box;
    for (auto p = first; p != last; ++p) box.add(*p);
    const Vec3 center = box.center().cast<float>().cast<double>();
    double radius = 0.0;
    for (auto p = first; p != last; ++p)
      radius = std::max(radius, (p->cast<float>().cast<double>() - center).norm());
    out.centerX.push_back(static_cast<float>(center.x()));
    out.centerY.push_back(static_cast<float>(center.y()));
    out.centerZ.push_back(static_cast<float>(center.z()));
    out.radius.push_back(static_cast<float>(radius * (1.0 + 1e-6)));  // covers rounding to float
    ++out.clusters;
    return;
  }
  Box box;
  for (auto p = first; p != last; ++p) box.add(*p);
  int axis = 0;
  box.size().maxCoeff(&axis);
  const auto clusters = (count + SamplePoints::width - 1) / SamplePoints::width;
  const auto middle = first + count * (clusters / 2) / clusters;
  const auto before = [axis](const Vec3& p, const Vec3& q) {
    return std::make_tuple(p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) <
           std::make_tuple(q[axis], q[(axis + 1) % 3], q[(axis + 2) % 3]);
  };
  std::sort(first, last, before);
  cluster(first, middle, out);
  cluster(middle, last, out);
}

SamplePoints clustered(std::vector<Vec3> points) {
  SamplePoints out;
  if (points.empty()) return out;
  cluster(points.begin(), points.end(), out);
  while (out.centerX.size() % SamplePoints::width != 0) {
    out.centerX.push_back(out.centerX.back());
    out.centerY.push_back(out.centerY.back());
    out.centerZ.push_back(out.centerZ.back());
    out.radius.push_back(out.radius.back());
  }
  return out;
}

}  // namespace

SamplePoints sampleSurface(const TriangleMesh& mesh, double spacing) {
  return clustered(pointsOn(mesh, spacing));
}

namespace {

/// Farthest-point sampling (Gonzalez 1985): the next point is always that furthest from all chosen ones. A
/// tree over the points limits the work to the surroundings of the chosen point.
class FarthestPoints {
 public:
  explicit FarthestPoints(const std::vector<Vec3>& points)
      : points_(points),
        squared_(points.size(), std::numeric_limits<double>::infinity()),
        order_(points.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    while (leaves_ * leafSize < points.size()) leaves_ *= 2;
    nodes_.resize(2 * leaves_);
    build(1, 0, points.size());
  }

  /// The first of the points furthest from all chosen ones.
  std::size_t furthest() const { return nodes_[1].furthest; }
  void choose(std::size_t point) { update(1, points_[point]); }

 private:
  static constexpr std::size_t leafSize = 8;
  struct Node {
    Box box;
    std::size_t begin = 0, end = 0;  ///< in order_
    std::size_t furthest = 0;        ///< point
    double squared = -1.0;  ///< its squared distance from the nearest chosen point [µm²]; no points: -1
  };

  void build(std::size_t n, std::size_t begin, std::size_t end) {
    Node& node = nodes_[n];
    node.begin = begin;
    node.end = end;
    for (std::size_t i = begin; i < end; ++i) node.box.add(points_[order_[i]]);
    if (n < leaves_) {
      int axis = 0;
      if (begin < end) node.box.size().maxCoeff(&axis);
      const std::size_t middle = begin + (end - begin) / 2;
      std::nth_element(
          order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](auto i, auto j) {
            return points_[i][axis] != points_[j][axis] ? points_[i][axis] < points_[j][axis] : i < j;
          });
      build(2 * n, begin, middle);
      build(2 * n + 1, middle, end);
    }
    summarise(n);
  }

  void summarise(std::size_t n) {
    Node& node = nodes_[n];
    node.squared = -1.0;
    const auto consider = [&](double squared, std::size_t point) {
      if (squared < node.squared || (squared == node.squared && point > node.furthest)) return;
      node.squared = squared;
      node.furthest = point;
    };
    if (n < leaves_)
      for (const std::size_t child : {2 * n, 2 * n + 1})
        consider(nodes_[child].squared, nodes_[child].furthest);
    else
      for (std::size_t i = node.begin; i < node.end; ++i) consider(squared_[order_[i]], order_[i]);
  }

  void update(std::size_t n, const Vec3& p) {
    constexpr double rounding = 1.0 + 1e-12;  // of a few operations
    const Node& node = nodes_[n];
    if (node.begin == node.end || node.box.squaredDistance(p) > rounding * node.squared) return;
    if (n < leaves_) {
      update(2 * n, p);
      update(2 * n + 1, p);
    } else {
      for (std::size_t i = node.begin; i < node.end; ++i) {
        double& squared = squared_[order_[i]];
        squared = std::min(squared, (points_[order_[i]] - p).squaredNorm());
      }
    }
    summarise(n);
  }

  const std::vector<Vec3>& points_;
  std::vector<double> squared_;  ///< distance of each point from the nearest chosen one [µm²]
  std::vector<std::size_t> order_;
  std::size_t leaves_ = 1;
  std::vector<Node> nodes_;  ///< a heap; the last `leaves_` are the leaves
};

}  // namespace

SamplePoints sampleCoarsely(const TriangleMesh& mesh) {
  const std::size_t wanted = std::min<std::size_t>(
      mesh.vertices.size(), std::max<std::size_t>(2 * SamplePoints::width, mesh.vertices.size() / 4));
  FarthestPoints vertices(mesh.vertices);
  std::vector<Vec3> chosen;
  std::size_t next = 0;
  while (chosen.size() < wanted) {
    pollAt(chosen.size());
    chosen.push_back(mesh.vertices[next]);
    vertices.choose(next);
    next = vertices.furthest();
  }
  return clustered(std::move(chosen));
}

std::vector<Vec3> spreadPoints(const TriangleMesh& mesh, int count) {
  const std::vector<Vec3>& all = mesh.vertices;
  std::vector<double> distance(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) distance[i] = all[i].squaredNorm();
  std::vector<Vec3> points;
  while (int(points.size()) < std::min<int>(count, int(all.size()))) {
    const auto next = std::max_element(distance.begin(), distance.end()) - distance.begin();
    points.push_back(all[next]);
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double toNext = (all[i] - points.back()).squaredNorm();
      distance[i] = points.size() == 1 ? toNext : std::min(distance[i], toNext);
    }
  }
  return points;
}

}  // namespace packmesh
