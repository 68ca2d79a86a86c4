// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/mesh_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "packMesh/core/error.h"
#include "packMesh/core/poll.h"
#include "packMesh/mesh/union_find.h"

namespace packmesh {

MeshHierarchy::MeshHierarchy(const TriangleMesh& mesh) : tree_(std::make_unique<MeshTree>(mesh)) {}
MeshHierarchy::MeshHierarchy(std::shared_ptr<const TriangleMesh> mesh, const MeshHierarchy& undeformed)
    : tree_(std::make_unique<MeshTree>(std::move(mesh), undeformed.tree())) {}
MeshHierarchy::~MeshHierarchy() = default;
MeshHierarchy::MeshHierarchy(MeshHierarchy&&) noexcept = default;
MeshHierarchy& MeshHierarchy::operator=(MeshHierarchy&&) noexcept = default;

const TriangleMesh& MeshHierarchy::mesh() const {
  return *tree_->mesh;
}

namespace {

/// Added to spreads, in units of the squared radius, so that those of flat meshes can be inverted.
constexpr double flattest = 1e-6;

/// Steps towards the smallest circle around a patch of a deformed mesh.
constexpr int fewSteps = 2;

/// Stored extents are enlarged by this fraction of the distances involved, to cover rounding to float.
constexpr double storage = 1e-6;

float up(double x) {
  return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

class TreeBuilder {
 public:
  explicit TreeBuilder(MeshTree& tree) : tree_(tree), mesh_(*tree.mesh) {
    const int count = static_cast<int>(mesh_.triangles.size());
    centroid_.reserve(count);
    normal_.reserve(count);
    for (int t = 0; t < count; ++t) {
      const Vec3 &a = mesh_.corner(t, 0), &b = mesh_.corner(t, 1), &c = mesh_.corner(t, 2);
      centroid_.push_back((a + b + c) / 3.0);
      normal_.push_back((b - a).cross(c - a).stableNormalized());
    }
    tree_.vertices.reserve(mesh_.vertices.size());
    for (const Vec3& v : mesh_.vertices)
      tree_.vertices.push_back(
          {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())});
  }

  void build() {
    const int count = static_cast<int>(mesh_.triangles.size());
    order_.resize(count);
    std::iota(order_.begin(), order_.end(), 0);
    tree_.discs.resize(count);
    addQuad({{0, count}}, 0, emptyDisc);
  }

  /// Fits the discs of a tree that has the patches of another mesh.
  void refit() {
    order_.reserve(mesh_.triangles.size());
    refit(0);
  }

 private:
  struct Range {
    int begin, end;  ///< in order_
    int size() const { return end - begin; }
  };

  /// Fits a quad and everything below it, and appends its triangles to order_.
  void refit(int index) {
    DiscQuad& quad = tree_.quads[index];
    for (int lane = 0; lane < 4; ++lane) {
      if (quad.discs.radius[lane] < 0.0f) continue;
      Range patch{static_cast<int>(order_.size()), 0};
      if (quad.content[lane] < 0) order_.push_back(~quad.content[lane]);
      if (quad.content[lane] >= 0) refit(quad.content[lane]);
      patch.end = static_cast<int>(order_.size());
      setLane(quad, lane, patch, fewSteps);
      if (quad.content[lane] >= 0) tree_.quads[quad.content[lane]].size = quad.discs.radius[lane];
    }
  }

  /// Adds a quad of the given patches and everything below it. Returns its index.
  /// @param disc,size index and size of the disc around them
  int addQuad(const std::vector<Range>& patches, int disc, float size) {
    const int index = static_cast<int>(tree_.quads.size());
    poll();
    tree_.quads.emplace_back();
    DiscQuad quad{};
    quad.disc = disc;
    quad.size = size;
    for (int lane = 0; lane < 4; ++lane) {
      if (lane >= static_cast<int>(patches.size())) {
        quad.discs.radius[lane] = quad.discs.half[lane] = -emptyDisc;
        continue;
      }
      const Range& patch = patches[lane];
      setLane(quad, lane, patch, patch.size() <= 64 ? 30 : 5);
      const int own = 4 * index + lane;
      if (patch.size() == 1) {
        quad.content[lane] = ~order_[patch.begin];
        tree_.discs[order_[patch.begin]] = own;
      } else {
        quad.content[lane] = addQuad(parts(patch), own, quad.discs.radius[lane]);
      }
    }
    tree_.quads[index] = quad;
    return index;
  }

  /// Divides a patch into two to four parts, as evenly as blocks of a power of four permit, so that lower
  /// quads are full and patches at the same depth have about the same size.
  std::vector<Range> parts(const Range& patch) {
    int size = 1;
    while (4 * size < patch.size()) size *= 4;
    std::vector<Range> out;
    cut(patch, std::max(size / 4, 1), (patch.size() + size - 1) / size, out);
    return out;
  }

  void cut(const Range& patch, int block, int count, std::vector<Range>& out) {
    if (count == 1) {
      out.push_back(patch);
      return;
    }
    const int blocks = (patch.size() + block - 1) / block, left = (count + 1) / 2;
    const int middle = patch.begin + (blocks * left + count / 2) / count * block;
    const Vec3 axis = longestDirection(patch);
    std::nth_element(order_.begin() + patch.begin, order_.begin() + middle, order_.begin() + patch.end,
                     [&](int i, int j) {
                       const double a = axis.dot(centroid_[i]), b = axis.dot(centroid_[j]);
                       return a != b ? a < b : i < j;
                     });
    cut({patch.begin, middle}, block, left, out);
    cut({middle, patch.end}, block, count - left, out);
  }

  Vec3 longestDirection(const Range& patch) const {
    Vec3 mean = Vec3::Zero();
    for (int i = patch.begin; i < patch.end; ++i) mean += centroid_[order_[i]];
    mean /= patch.size();
    Mat3 covariance = Mat3::Zero();
    for (int i = patch.begin; i < patch.end; ++i)
      covariance += Mat3::outerProduct(centroid_[order_[i]] - mean, centroid_[order_[i]] - mean);
    return principalAxes(covariance).vectors.col(2);
  }

  /// @param steps towards the smallest circle
  void setLane(DiscQuad& quad, int lane, const Range& patch, int steps) const {
    Vec3 mean = Vec3::Zero(), facing = Vec3::Zero();
    for (int i = patch.begin; i < patch.end; ++i) {
      mean += centroid_[order_[i]];
      facing += normal_[order_[i]];
    }
    mean /= patch.size();
    Vec3 normal;
    if (steps <= fewSteps && facing.norm() > 0.5 * patch.size()) {
      normal = facing.normalized();
    } else {
      Mat3 covariance = Mat3::Zero();
      forEachCorner(patch, [&](const Vec3& v) { covariance += Mat3::outerProduct(v - mean, v - mean); });
      const Vec3 thin = principalAxes(covariance).vectors.col(0);
      const Vec3 even = facing.norm() > 0.5 ? Vec3(facing.normalized()) : thin;
      normal = thickness(patch, even) < thickness(patch, thin) ? even : thin;
    }
    Vec3 stored;
    for (int k = 0; k < 3; ++k) stored[k] = quad.discs.normal[k][lane] = static_cast<float>(normal[k]);

    // Centre of the slab; in its plane, the centre of a small circle (moves towards the furthest point: M.
    // Badoiu, K. Clarkson, SODA 2003).
    double low = std::numeric_limits<double>::infinity(), high = -low;
    forEachCorner(patch, [&](const Vec3& v) {
      const double along = stored.dot(v - mean);
      low = std::min(low, along);
      high = std::max(high, along);
    });
    Vec3 center = mean;
    for (int step = 1; step <= steps; ++step) {
      Vec3 furthest = center;
      double most = 0.0;
      forEachCorner(patch, [&](const Vec3& v) {
        const Vec3 offset = v - center, across = offset - stored.dot(offset) * stored;
        const double squared = across.squaredNorm();
        if (squared > most) most = squared, furthest = center + across;
      });
      center += (furthest - center) / (step + 1);
    }
    center += (0.5 * (low + high) - stored.dot(center - mean)) * stored;
    for (int k = 0; k < 3; ++k) center[k] = quad.discs.center[k][lane] = static_cast<float>(center[k]);

    double half = 0.0, radius = 0.0, reach = 0.0;
    forEachCorner(patch, [&](const Vec3& v) {
      half = std::max(half, std::abs(stored.dot(v - center)));
      radius = std::max(radius, (v - center).norm());
      reach = std::max(reach, v.norm());
    });
    quad.discs.half[lane] = up(half + storage * (radius + 0.1 * reach));
    quad.discs.radius[lane] = up(radius + storage * (radius + 0.1 * reach));
  }

  double thickness(const Range& patch, const Vec3& normal) const {
    Box along;
    forEachCorner(patch, [&](const Vec3& v) { along.add(Vec3::Constant(normal.dot(v))); });
    return along.size()[0];
  }

  template <class Visit>
  void forEachCorner(const Range& patch, Visit&& visit) const {
    for (int i = patch.begin; i < patch.end; ++i)
      for (int k = 0; k < 3; ++k) visit(mesh_.corner(order_[i], k));
  }

  MeshTree& tree_;
  const TriangleMesh& mesh_;
  std::vector<int> order_;
  std::vector<Vec3> centroid_, normal_;
};

/// One vertex of every connected component.
std::vector<int> componentSamples(const TriangleMesh& mesh) {
  UnionFind components(mesh.vertices.size());
  for (const Triangle& t : mesh.triangles)
    for (int k = 1; k < 3; ++k) components.join(t[0], t[k]);
  std::vector<int> samples;
  for (const Triangle& t : mesh.triangles)
    for (int v : t)
      if (components.first(v) == v) samples.push_back(v);
  std::sort(samples.begin(), samples.end());
  samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
  return samples;
}

std::shared_ptr<const TriangleMesh> notEmpty(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) throw MeshError("cannot build a hierarchy of a mesh without triangles");
  return std::make_shared<const TriangleMesh>(mesh);
}

Vec3 volumeCentroid(const TriangleMesh& mesh, const Vec3& origin) {
  Vec3 moment = Vec3::Zero();
  double volume = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - origin, b = mesh.vertices[t[1]] - origin,
               c = mesh.vertices[t[2]] - origin;
    const double six = a.dot(b.cross(c));
    volume += six;
    moment += six / 4.0 * (a + b + c);
  }
  return volume != 0.0 ? Vec3(origin + moment / volume) : origin;
}

}  // namespace

MeshTree::MeshTree(const TriangleMesh& source) : mesh(notEmpty(source)), hull(source) {
  TreeBuilder(*this).build();
  measure();
}

MeshTree::MeshTree(std::shared_ptr<const TriangleMesh> deformed, const MeshTree& undeformed)
    : mesh(std::move(deformed)),
      quads(undeformed.quads),
      discs(undeformed.discs),
      samples(undeformed.samples) {
  TreeBuilder(*this).refit();
  measure();
}

void MeshTree::measure() {
  Box box;
  reach = 0.0;
  const std::vector<Vec3>& vertex = mesh->vertices;
  for (const Triangle& t : mesh->triangles)
    for (int v : t) {
      box.add(vertex[v]);
      reach = std::max(reach, vertex[v].norm());
    }
  center = box.center();
  radius = 0.0;
  for (const Triangle& t : mesh->triangles)
    for (int v : t) radius = std::max(radius, (vertex[v] - center).norm());
  spread = flattest * radius * radius * Mat3::Identity();
  const std::vector<Vec3>& points = hull.points().empty() ? vertex : hull.points();
  for (const Vec3& v : points) spread += Mat3::outerProduct(v - center, v - center) / double(points.size());
  volume = std::abs(signedVolume(*mesh));
  centroid = volumeCentroid(*mesh, center);
  if (samples.empty()) samples = componentSamples(*mesh);
}

double largestStretch(const Mat3& linear) {
  const Mat3 squares = (linear.transpose() * linear).cwiseAbs();
  double largest = 0.0;  // sum of a row, which is a column
  for (int k = 0; k < 3; ++k) {
    const Vec3& v = squares.col(k);
    largest = std::max(largest, v.x() + (v.y() + v.z()));
  }
  return std::sqrt(largest);
}

TriangleTree::TriangleTree(const TriangleMesh& mesh) : order_(mesh.triangles.size()) {
  constexpr int leafSize = 4;
  if (mesh.triangles.empty()) return;
  std::iota(order_.begin(), order_.end(), 0);
  std::vector<Box> boxes(mesh.triangles.size());
  for (std::size_t t = 0; t < boxes.size(); ++t)
    for (const int v : mesh.triangles[t]) boxes[t].add(mesh.vertices[v]);

  // Halves every range at the median of the longest side, which limits the depth to 32.
  nodes_.push_back({Box(), 0, static_cast<int>(order_.size())});
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const int first = nodes_[n].first, count = nodes_[n].count;
    Box middles;
    for (int e = first; e < first + count; ++e) {
      nodes_[n].box.add(boxes[order_[e]]);
      middles.add(boxes[order_[e]].center());
    }
    pollAt(n);
    if (count <= leafSize) continue;
    int axis = 0;
    middles.size().maxCoeff(&axis);
    const int half = count / 2;
    std::nth_element(order_.begin() + first, order_.begin() + first + half, order_.begin() + first + count,
                     [&](int s, int t) {
                       const double a = boxes[s].lo[axis] + boxes[s].hi[axis],
                                    b = boxes[t].lo[axis] + boxes[t].hi[axis];
                       return a != b ? a < b : s < t;
                     });
    nodes_[n].first = static_cast<int>(nodes_.size());
    nodes_[n].count = 0;
    nodes_.push_back({Box(), first, half});
    nodes_.push_back({Box(), first + half, count - half});
  }
  for (const int t : order_) boxes_.push_back(boxes[t]);
}

namespace {

/// A box around the unit vectors from one vertex of a triangle to its points: around the ends of an arc,
/// enlarged by the height of the arc and for rounding.
Box directionsFrom(const TriangleMesh& mesh, int vertex, const Triangle& triangle) {
  constexpr double rounding = 1e-12;
  Box box;
  Vec3 ends[2];
  int n = 0;
  for (const int v : triangle)
    if (v != vertex) box.add(ends[n++] = (mesh.vertices[v] - mesh.vertices[vertex]).stableNormalized());
  const double halfChord2 = 0.25 * (ends[1] - ends[0]).squaredNorm();
  return box.grownBy(1.0 - std::sqrt(std::max(0.0, 1.0 - halfChord2)) + rounding);
}

}  // namespace

std::vector<TriangleTree::Fan> TriangleTree::fansIn(const TriangleMesh& mesh) const {
  std::vector<int> triangles(mesh.vertices.size(), 0);
  for (const Triangle& t : mesh.triangles)
    for (const int v : t) ++triangles[v];
  // Up to three vertices that all triangles of a node have, then -1. Children follow their nodes.
  std::vector<Triangle> common(nodes_.size(), {-1, -1, -1});
  const auto restrict = [](Triangle& to, const Triangle& by) {
    Triangle both = {-1, -1, -1};
    int n = 0;
    for (const int v : to)
      if (v >= 0 && std::find(by.begin(), by.end(), v) != by.end()) both[n++] = v;
    to = both;
  };
  std::vector<Fan> fans(nodes_.size());
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    const Node& node = nodes_[n];
    if (node.count == 0) {
      common[n] = common[node.first];
      restrict(common[n], common[node.first + 1]);
    } else {
      common[n] = mesh.triangles[order_[node.first]];
      for (int e = node.first + 1; e < node.first + node.count; ++e)
        restrict(common[n], mesh.triangles[order_[e]]);
    }
    for (const int v : common[n])
      if (v >= 0 && (fans[n].vertex < 0 || triangles[v] > triangles[fans[n].vertex])) fans[n].vertex = v;
    if (fans[n].vertex < 0) continue;
    const int apex = fans[n].vertex;
    if (node.count == 0 && fans[node.first].vertex == apex && fans[node.first + 1].vertex == apex) {
      for (const int child : {node.first, node.first + 1}) fans[n].directions.add(fans[child].directions);
    } else if (node.count > 0) {
      for (int e = node.first; e < node.first + node.count; ++e)
        fans[n].directions.add(directionsFrom(mesh, apex, mesh.triangles[order_[e]]));
    } else {
      fans[n].directions = {-Vec3::Ones(), Vec3::Ones()};
    }
  }
  return fans;
}

}  // namespace packmesh
