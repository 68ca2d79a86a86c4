// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/field/rough_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "packMesh/core/poll.h"
#include "packMesh/mesh/facet.h"

namespace packmesh {
namespace {

/// Computes the nearest point of the surface for the nodes near each triangle, passes nearest points on from
/// node to node (P.-E. Danielsson, "Euclidean distance mapping", Computer Graphics and Image Processing 14,
/// 1980), and determines the sign by the number of times that rows of nodes enter and leave the mesh.
class RoughSampler {
 public:
  RoughSampler(const TriangleMesh& mesh, DistanceGrid& grid)
      : mesh_(mesh), grid_(grid), step_{1, grid.nodes[0], std::ptrdiff_t(grid.nodes[0]) * grid.nodes[1]} {
    nearest_.resize(grid.value.size());
    facets_.reserve(mesh.triangles.size());
    for (int t = 0; t < int(mesh.triangles.size()); ++t)
      facets_.emplace_back(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
    grid.value.assign(grid.value.size(), std::numeric_limits<float>::infinity());
  }

  void fill() {
    for (int t = 0; t < int(facets_.size()); ++t) seed(t);
    for (const int direction : {+1, -1}) passAlongLayers(direction);
    refine();
    for (float& squared : grid_.value) squared = std::sqrt(squared);
    setSigns();
  }

 private:
  /// Nodes [begin, end) of a row along an axis whose coordinates are between two.
  struct Range {
    int begin, end;
  };
  Range between(int axis, double low, double high) const {
    const double first = std::ceil((low - grid_.origin[axis]) / grid_.spacing),
                 last = std::floor((high - grid_.origin[axis]) / grid_.spacing);
    return {int(std::max(first, 0.0)), int(std::min<double>(last, grid_.nodes[axis] - 1)) + 1};
  }
  double at(int axis, int node) const { return grid_.origin[axis] + grid_.spacing * node; }
  std::ptrdiff_t indexOf(int i, int j, int k) const { return i + step_[1] * j + step_[2] * k; }

  /// Offers a triangle to all nodes within a spacing of it.
  void seed(int t) {
    const Facet& facet = facets_[t];
    const Vec3 normal = facet.u.cross(facet.v).normalized(), center = facet.a + (facet.u + facet.v) / 3.0;
    const double reach = grid_.spacing;
    double radius = 0.0;
    Box box;
    for (int c = 0; c < 3; ++c) {
      box.add(mesh_.corner(t, c));
      radius = std::max(radius, (mesh_.corner(t, c) - center).norm());
    }
    Range nodes[3];
    for (int k = 0; k < 3; ++k) nodes[k] = between(k, box.lo[k] - reach, box.hi[k] + reach);
    for (int k = nodes[2].begin; k < nodes[2].end; ++k)
      for (int j = nodes[1].begin; j < nodes[1].end; ++j) {
        std::ptrdiff_t node = indexOf(nodes[0].begin, j, k);
        for (int i = nodes[0].begin; i < nodes[0].end; ++i, ++node) {
          const Vec3 p(at(0, i), at(1, j), at(2, k));
          const double height = normal.dot(p - center), least = std::max(0.0, (p - center).norm() - radius);
          if (std::max(height * height, least * least) < std::min<double>(grid_.value[node], reach * reach))
            offer(node, p, t);
        }
      }
  }

  void offer(std::ptrdiff_t node, const Vec3& p, int t) {
    const Vec3 point = facets_[t].at(facets_[t].nearest(p));
    const auto squared = float((point - p).squaredNorm());
    if (squared >= grid_.value[node]) return;
    grid_.value[node] = squared;
    nearest_[node] = {point.cast<float>(), t};
  }

  /// Replaces the points passed on, next to those nodes that had triangles nearby, by the nearest ones of
  /// their triangles.
  void refine() {
    const float reach = float(4.0 * grid_.spacing * grid_.spacing);
    std::ptrdiff_t node = 0;
    for (int k = 0; k < grid_.nodes[2]; ++k)
      for (int j = 0; j < grid_.nodes[1]; ++j)
        for (int i = 0; i < grid_.nodes[0]; ++i, ++node)
          if (grid_.value[node] < reach)
            offer(node, Vec3(at(0, i), at(1, j), at(2, k)), nearest_[node].triangle);
  }

  void passAlongLayers(int direction) {
    forEach(2, direction, [&](int k, bool first) {
      for (int j = 0; j < grid_.nodes[1] && !first; ++j)
        for (int i = 0; i < grid_.nodes[0]; ++i) learn(i, j, k, -direction * step_[2]);
      for (const int inLayer : {+1, -1}) passAlongRows(k, inLayer);
    });
  }

  void passAlongRows(int k, int direction) {
    forEach(1, direction, [&](int j, bool first) {
      for (int i = 0; i < grid_.nodes[0] && !first; ++i) learn(i, j, k, -direction * step_[1]);
      for (const int inRow : {+1, -1})
        forEach(0, inRow, [&](int i, bool begins) {
          if (!begins) learn(i, j, k, -inRow * step_[0]);
        });
    });
  }

  /// Calls visit(node, whether it is the first one) along an axis.
  template <class Visit>
  void forEach(int axis, int direction, Visit&& visit) const {
    const int n = grid_.nodes[axis];
    for (int m = 0; m < n; ++m) visit(direction > 0 ? m : n - 1 - m, m == 0);
  }

  /// Takes the nearest point of an adjacent node if it is nearer than the own one.
  void learn(int i, int j, int k, std::ptrdiff_t from) {
    const std::ptrdiff_t node = indexOf(i, j, k);
    if (!std::isfinite(grid_.value[node + from])) return;
    const Eigen::Vector3f p(float(at(0, i)), float(at(1, j)), float(at(2, k)));
    const float squared = (nearest_[node + from].point - p).squaredNorm();
    if (squared >= grid_.value[node]) return;
    grid_.value[node] = squared;
    nearest_[node] = nearest_[node + from];
  }

  /// A point of the surface, and its triangle.
  struct Nearest {
    Eigen::Vector3f point;
    int triangle;
  };

  /// A place where a row of nodes enters (+1) or leaves (-1) the mesh.
  struct Crossing {
    int row;
    double x;
    int sign;
  };

  void setSigns() {
    std::vector<Crossing> crossings;
    // Rows are moved a little, so that they meet no vertex; if they leave the mesh less often than they enter
    // it, they did.
    for (int tries = 1; tries < 10 && !findCrossings(tries * 1e-7 * grid_.spacing, crossings);) ++tries;
    std::vector<int> depth(grid_.value.size(), 0);
    for (const Crossing& c : crossings) {
      const std::ptrdiff_t row = std::ptrdiff_t(c.row) * grid_.nodes[0];
      for (int i = between(0, c.x, at(0, grid_.nodes[0])).begin; i < grid_.nodes[0]; ++i)
        depth[row + i] += c.sign;
    }
    for (std::size_t n = 0; n < depth.size(); ++n)
      if (depth[n] > 0) grid_.value[n] = -grid_.value[n];
  }

  /// @param aside rows are moved by this [µm]
  /// @return whether every row leaves the mesh as often as it enters it
  bool findCrossings(double aside, std::vector<Crossing>& crossings) const {
    crossings.clear();
    std::vector<int> balance(std::size_t(grid_.nodes[1]) * grid_.nodes[2], 0);
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      Box box;
      for (int c = 0; c < 3; ++c) box.add(mesh_.corner(int(t), c));
      const Range rows = between(1, box.lo[1] - aside, box.hi[1]),
                  layers = between(2, box.lo[2] - aside, box.hi[2]);
      for (int k = layers.begin; k < layers.end; ++k)
        for (int j = rows.begin; j < rows.end; ++j) {
          const int row = k * grid_.nodes[1] + j;
          if (const auto crossing = crossingOf(int(t), row, at(1, j) + aside, at(2, k) + 0.7 * aside)) {
            crossings.push_back(*crossing);
            balance[row] += crossing->sign;
          }
        }
    }
    return std::all_of(balance.begin(), balance.end(), [](int sum) { return sum == 0; });
  }

  std::optional<Crossing> crossingOf(int t, int row, double y, double z) const {
    const Triangle& corners = mesh_.triangles[t];
    double weight[3];  // of the corner opposite to each edge
    int left = 0;
    for (int e = 0; e < 3; ++e) {
      // From the lower vertex to the higher one, so that both triangles of an edge compute the same.
      const int from = corners[(e + 1) % 3], to = corners[(e + 2) % 3];
      const Vec3 &a = mesh_.vertices[std::min(from, to)], &b = mesh_.vertices[std::max(from, to)];
      const double side = (b[1] - a[1]) * (z - a[2]) - (b[2] - a[2]) * (y - a[1]);
      left += (side >= 0.0) == (from < to);
      weight[e] = from < to ? side : -side;
    }
    if (left != 0 && left != 3) return {};
    const double sum = weight[0] + weight[1] + weight[2];
    double x = 0.0;
    for (int e = 0; e < 3; ++e) x += weight[e] / sum * mesh_.vertices[corners[e]][0];
    // Seen along x, triangles that face against it are traversed clockwise.
    return Crossing{row, x, left == 3 ? -1 : +1};
  }

  const TriangleMesh& mesh_;
  DistanceGrid& grid_;  ///< until the end, its values are squares [µm²]
  std::vector<Facet> facets_;
  std::vector<Nearest> nearest_;  ///< of each node, so far
  std::ptrdiff_t step_[3];
};

}  // namespace

DistanceGrid sampleRoughly(const TriangleMesh& mesh, const Box& region, double spacing) {
  poll();
  DistanceGrid grid = emptyGrid(region, spacing);
  RoughSampler(mesh, grid).fill();
  return grid;
}

}  // namespace packmesh
