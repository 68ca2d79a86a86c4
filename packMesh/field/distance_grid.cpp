// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/field/distance_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "packMesh/core/error.h"
#include "packMesh/core/poll.h"
#include "packMesh/core/vector.h"
#include "packMesh/mesh/closest_point.h"

namespace packmesh {
namespace {

/// Largest grid [bytes].
constexpr double largestGrid = 2e9;

}  // namespace

DistanceGrid emptyGrid(const Box& region, double spacing) {
  if (region.empty() || !(spacing > 0.0) || !std::isfinite(spacing) || !region.size().allFinite())
    throw InputError("a distance grid needs a region and a positive spacing, found a spacing of " +
                     toText(spacing) + " µm");
  DistanceGrid grid;
  grid.origin = region.lo;
  grid.spacing = spacing;
  double bytes = sizeof(float);
  for (int k = 0; k < 3; ++k) bytes *= std::max(2.0, std::ceil(region.size()[k] / spacing) + 1.0);
  if (bytes > largestGrid)
    throw InputError("a distance grid of " + toText(bytes / 1e9, 3) + " GB would be needed for a region of " +
                     toText(region.size().x(), 4) + " x " + toText(region.size().y(), 4) + " x " +
                     toText(region.size().z(), 4) + " µm at a spacing of " + toText(spacing, 4) +
                     " µm; at most 2 GB are allowed: is the unit of length right?");
  for (int k = 0; k < 3; ++k)
    grid.nodes[k] = std::max(2, static_cast<int>(std::ceil(region.size()[k] / spacing)) + 1);
  grid.value.resize(std::size_t(grid.nodes[0]) * grid.nodes[1] * grid.nodes[2]);
  return grid;
}

namespace {

/// Fills a grid: for nodes next to the surface, every triangle near them is tested; nearest triangles are
/// then propagated from node to node in sweeps (after P.-E. Danielsson, "Euclidean distance mapping",
/// Computer Graphics and Image Processing 14, 1980, with triangles instead of pixels); finally the band is
/// searched exactly.
class Sampler {
 public:
  Sampler(const MeshHierarchy& mesh, DistanceGrid& grid, const Threads& threads)
      : mesh_(mesh.mesh()),
        surface_(mesh.mesh()),
        search_(mesh.tree(), surface_),
        byDiscs_(search_.resolves(grid.spacing)),
        threads_(threads),
        grid_(grid) {
    nearest_.assign(grid.value.size(), -1);
    grid_.value.assign(grid.value.size(), std::numeric_limits<float>::infinity());
    step_[0] = 1;
    step_[1] = grid.nodes[0];
    step_[2] = step_[1] * grid.nodes[1];
  }

  /// @param exact distances up to this are searched, the others propagated [µm]
  void fill(double exact) {
    const bool bySearch = searchIsCheaper(exact);
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      pollAt(t);
      seed(static_cast<int>(t), bySearch ? grid_.spacing : exact);
    }
    seedFaces();
    sweep(2, +1);
    sweep(2, -1);
    finish(bySearch ? exact : 0.0);
  }

 private:
  Vec3 position(int i, int j, int k) const { return grid_.origin + grid_.spacing * Vec3(i, j, k); }
  /// Assigns triangle t to node (i,j,k) if it is nearer than the current one.
  void offer(std::size_t node, int i, int j, int k, int t) {
    if (t == nearest_[node]) return;
    const float distance = static_cast<float>(surface_.onTriangle(t, position(i, j, k)).distance);
    if (distance < grid_.value[node]) {
      grid_.value[node] = distance;
      nearest_[node] = t;
    }
  }

  /// Whether to search the nearest triangle for every node of the band, or to test every triangle at all
  /// nodes near it: the latter is faster if triangles are large.
  bool searchIsCheaper(double exact) const {
    constexpr double searchPerOffer = 20.0;  // measured: 0.3 µs against 15 ns
    double offers = 0.0;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      Box box;
      for (const int v : mesh_.triangles[t]) box.add(mesh_.vertices[v]);
      offers += (box.size().array() + 2.0 * exact).prod();
    }
    return offers > searchPerOffer * 2.0 * exact * surfaceArea(mesh_);
  }

  /// Tests triangle t at least at the nodes nearer than `reach` to both its plane and its bounding box.
  void seed(int t, double reach) {
    Box box;
    for (int c = 0; c < 3; ++c) box.add(mesh_.corner(t, c));
    int lo[3], hi[3];
    for (int k = 0; k < 3; ++k) {
      const double first = std::ceil((box.lo[k] - reach - grid_.origin[k]) / grid_.spacing);
      const double last = std::floor((box.hi[k] + reach - grid_.origin[k]) / grid_.spacing);
      if (first > grid_.nodes[k] - 1 || last < 0.0) return;
      lo[k] = static_cast<int>(std::max(0.0, first));
      hi[k] = static_cast<int>(std::min<double>(grid_.nodes[k] - 1, last));
    }
    const Vec3& a = mesh_.corner(t, 0);
    const Vec3 normal = (mesh_.corner(t, 1) - a).cross(mesh_.corner(t, 2) - a).normalized();
    const double perNode = normal.x() * grid_.spacing;
    for (int k = lo[2]; k <= hi[2]; ++k)
      for (int j = lo[1]; j <= hi[1]; ++j) {
        // Nodes i with |height + i perNode| <= reach
        const double height = normal.dot(position(0, j, k) - a);
        double first = lo[0], last = hi[0];
        if (std::abs(perNode) * grid_.nodes[0] > reach) {
          const double one = (-reach - height) / perNode, other = (reach - height) / perNode;
          first = std::max(first, std::ceil(std::min(one, other)));
          last = std::min(last, std::floor(std::max(one, other)));
        } else if (std::abs(height) > 2.0 * reach) {
          continue;
        }
        if (first > last) continue;
        for (int i = static_cast<int>(first); i <= static_cast<int>(last); ++i)
          offer(i + step_[1] * j + step_[2] * k, i, j, k, t);
      }
  }

  /// Searches the nearest triangle for the nodes on those faces of the grid that the mesh crosses, and for at
  /// least one node: from there, triangles outside the grid are propagated.
  void seedFaces() {
    const Box mesh = boundingBox(mesh_), box = grid_.box();
    const auto search = [&](int i, int j, int k) {
      offer(i + step_[1] * j + step_[2] * k, i, j, k, surface_.nearest(position(i, j, k)).triangle);
    };
    search(0, 0, 0);
    for (int axis = 0; axis < 3; ++axis)
      for (int end = 0; end < 2; ++end) {
        if (end == 0 ? mesh.lo[axis] >= box.lo[axis] : mesh.hi[axis] <= box.hi[axis]) continue;
        int n[3];
        n[axis] = end == 0 ? 0 : grid_.nodes[axis] - 1;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (n[v] = 0; n[v] < grid_.nodes[v]; ++n[v])
          for (n[u] = 0; n[u] < grid_.nodes[u]; ++n[u]) search(n[0], n[1], n[2]);
      }
  }

  /// Propagates triangles across the layers along `axis` in the given direction, and then within each layer.
  void sweep(int axis, int direction, int j = 0, int k = 0) {
    const int n = grid_.nodes[axis];
    for (int at = direction > 0 ? 0 : n - 1; at >= 0 && at < n; at += direction) {
      const int before = at - direction;
      const bool first = before < 0 || before >= n;
      if (axis == 2) poll();
      if (axis == 0) {
        if (!first) learn(at, j, k, -direction * step_[0]);
        continue;
      }
      if (!first)
        for (int row = 0; row < (axis == 2 ? grid_.nodes[1] : 1); ++row)
          for (int i = 0; i < grid_.nodes[0]; ++i)
            learn(i, axis == 2 ? row : at, axis == 2 ? at : k, -direction * step_[axis]);
      for (const int inner : {+1, -1}) sweep(axis - 1, inner, axis == 1 ? at : 0, axis == 2 ? at : k);
    }
  }

  void learn(int i, int j, int k, std::ptrdiff_t from) {
    const std::size_t node = i + step_[1] * j + step_[2] * k;
    const int t = nearest_[node + from];
    // The distance to a triangle decreases by at most the step.
    if (t >= 0 && grid_.value[node + from] - grid_.spacing < grid_.value[node]) offer(node, i, j, k, t);
  }

  /// Searches the band exactly and determines the sign at every node: beyond a spacing from the surface it is
  /// that of the adjacent node; nearer, it is computed.
  void finish(double exact) {
    side_.assign(grid_.value.size(), 0);
    const int rows = (grid_.nodes[1] + packet[1] - 1) / packet[1],
              layers = (grid_.nodes[2] + packet[2] - 1) / packet[2];
    threads_.forEach(std::int64_t(rows) * layers, [&](std::int64_t row, int) {
      poll();
      const int j = static_cast<int>(row % rows) * packet[1], k = static_cast<int>(row / rows) * packet[2];
      for (int i = 0; i < grid_.nodes[0]; i += packet[0]) examine(i, j, k, exact);
    });
    std::size_t node = 0;
    for (int k = 0; k < grid_.nodes[2]; ++k)
      for (int j = 0; j < grid_.nodes[1]; ++j)
        for (int i = 0; i < grid_.nodes[0]; ++i, ++node) {
          const std::ptrdiff_t before = i > 0 ? step_[0] : j > 0 ? step_[1] : step_[2];
          const bool negative =
              side_[node] != 0 ? side_[node] < 0 : node > 0 && std::signbit(grid_.value[node - before]);
          if (negative) grid_.value[node] = -grid_.value[node];
        }
  }

  /// Nodes that are searched together.
  static constexpr int packet[3] = {4, 2, 2};

  /// Searches the nodes of the packet that begins at (i, j, k), and determines on which side those are that
  /// are near the surface.
  void examine(int i, int j, int k, double exact) {
    DiscSearch::Query query;
    std::array<std::ptrdiff_t, DiscSearch::points> nodes;
    int count = 0;
    for (int dk = 0; dk < packet[2] && k + dk < grid_.nodes[2]; ++dk)
      for (int dj = 0; dj < packet[1] && j + dj < grid_.nodes[1]; ++dj)
        for (int di = 0; di < packet[0] && i + di < grid_.nodes[0]; ++di) {
          const std::ptrdiff_t node = i + di + step_[1] * (j + dj) + step_[2] * (k + dk);
          const float value = grid_.value[node];
          // Propagation may miss the nearest triangle by a small amount: hence more than `exact` is searched.
          const bool search = value <= 1.05 * exact || node == 0;
          const Vec3 p = position(i + di, j + dj, k + dk);
          if (search && byDiscs_) {
            query.point[count] = p;
            query.atMost[count] = value;
            nodes[count++] = node;
          } else if (search) {
            take(node, p, surface_.nearest(p, nearest_[node]));
          } else if (value < 1.5 * grid_.spacing) {
            take(node, p, surface_.onTriangle(nearest_[node], p));
          }
        }
    if (count == 0) return;
    for (int n = count; n < DiscSearch::points; ++n) {
      query.point[n] = query.point[0];
      query.atMost[n] = -1.0;
    }
    search_.search(query);
    for (int n = 0; n < count; ++n) take(nodes[n], query.point[n], query.nearest[n]);
  }

  void take(std::ptrdiff_t node, const Vec3& p, const ClosestPoint::Nearest& nearest) {
    grid_.value[node] = static_cast<float>(nearest.distance);
    if (node == 0 || nearest.distance < 1.5 * grid_.spacing)
      side_[node] = static_cast<signed char>(surface_.side(p, nearest));
  }

  const TriangleMesh& mesh_;
  const ClosestPoint surface_;
  const DiscSearch search_;
  bool byDiscs_;
  const Threads& threads_;
  DistanceGrid& grid_;
  std::vector<signed char> side_;  ///< of each node, where it is computed: -1 inside, 1 outside; else 0
  std::vector<int> nearest_;       ///< nearest triangle of each node so far
  std::ptrdiff_t step_[3];
};

}  // namespace

DistanceGrid sampleDistance(const MeshHierarchy& mesh, const Box& region, double spacing, double band,
                            const Threads& threads) {
  DistanceGrid grid = emptyGrid(region, spacing);
  Sampler(mesh, grid, threads).fill(std::max(band, 3.0 * spacing));
  return grid;
}

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
    const Vec3f p(float(at(0, i)), float(at(1, j)), float(at(2, k)));
    const float squared = (nearest_[node + from].point - p).squaredNorm();
    if (squared >= grid_.value[node]) return;
    grid_.value[node] = squared;
    nearest_[node] = nearest_[node + from];
  }

  /// A point of the surface, and its triangle.
  struct Nearest {
    Vec3f point;
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
