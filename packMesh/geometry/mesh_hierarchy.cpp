// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/geometry/mesh_hierarchy.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "packMesh/error.h"

namespace packmesh {

namespace {

/// Stored extents grow by this fraction of the distances that entered them, against rounding to float.
constexpr double storage = 1e-6;

float up(double x) {
  return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

class TreeBuilder {
 public:
  explicit TreeBuilder(MeshTree& tree) : tree_(tree), mesh_(tree.mesh) {
    order_.resize(mesh_.triangles.size());
    std::iota(order_.begin(), order_.end(), 0);
    for (const Triangle& t : mesh_.triangles)
      centroid_.push_back((mesh_.vertices[t[0]] + mesh_.vertices[t[1]] + mesh_.vertices[t[2]]) / 3.0);
    add(0, static_cast<int>(order_.size()));
  }

 private:
  /// Adds the box of order_[begin, end) and everything below it. Returns its index.
  int add(int begin, int end) {
    const int index = static_cast<int>(tree_.boxes.size());
    tree_.boxes.push_back({});
    const TreeBox fitted = fit(begin, end);
    tree_.boxes[index] = fitted;
    int content;
    if (end - begin <= 4) {
      content = ~static_cast<int>(tree_.leaves.size());
      tree_.leaves.push_back(leaf(begin, end));
    } else {
      content = static_cast<int>(tree_.quads.size());
      tree_.quads.emplace_back();
      int cuts[5] = {begin, begin, split(begin, end, fitted.box), end, end};
      cuts[1] = split(begin, cuts[2], fit(begin, cuts[2]).box);
      cuts[3] = split(cuts[2], end, fit(cuts[2], end).box);
      BoxQuad quad{};
      for (Float4& half : quad.half) half = splat(-1e30f);
      int lane = 0;
      for (int part = 0; part < 4; ++part)
        if (cuts[part] < cuts[part + 1]) setLane(quad, lane++, add(cuts[part], cuts[part + 1]));
      for (; lane < 4; ++lane) quad.box[lane] = -1;
      tree_.quads[content] = quad;
    }
    tree_.boxes[index].content = content;
    return index;
  }

  void setLane(BoxQuad& quad, int lane, int box) const {
    const OrientedBox& b = tree_.boxes[box].box;
    quad.box[lane] = box;
    for (int k = 0; k < 3; ++k) {
      quad.center[k][lane] = b.center[k];
      quad.half[k][lane] = b.half[k];
      for (int c = 0; c < 3; ++c) quad.axis[k][c][lane] = b.axis[k][c];
    }
  }

  /// Orders [begin, end) along the longest side of its box; the halves are whole leaves of four.
  int split(int begin, int end, const OrientedBox& box) {
    const int leaves = (end - begin + 3) / 4;
    if (leaves < 2) return end;
    const int middle = begin + leaves / 2 * 4;
    const int longest = static_cast<int>(std::max_element(box.half, box.half + 3) - box.half);
    const Vec3 axis(box.axis[longest][0], box.axis[longest][1], box.axis[longest][2]);
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](int i, int j) {
                       const double a = axis.dot(centroid_[i]), b = axis.dot(centroid_[j]);
                       return a != b ? a < b : i < j;
                     });
    return middle;
  }

  /// Box along the principal axes of the corners of order_[begin, end).
  TreeBox fit(int begin, int end) const {
    Vec3 mean = Vec3::Zero();
    for (int i = begin; i < end; ++i) mean += centroid_[order_[i]];
    mean /= end - begin;
    Mat3 covariance = Mat3::Zero();
    forEachCorner(begin, end, [&](const Vec3& v) { covariance += (v - mean) * (v - mean).transpose(); });
    const Mat3 axes = Eigen::SelfAdjointEigenSolver<Mat3>(covariance).eigenvectors().transpose();

    TreeBox out{};
    Mat3 stored;
    for (int j = 0; j < 3; ++j)
      for (int c = 0; c < 3; ++c) stored(j, c) = out.box.axis[j][c] = static_cast<float>(axes(j, c));
    Box extent;
    forEachCorner(begin, end, [&](const Vec3& v) { extent.add(stored * (v - mean)); });
    const Vec3 center = mean + stored.transpose() * extent.center();
    for (int c = 0; c < 3; ++c) out.box.center[c] = static_cast<float>(center[c]);
    const Vec3 from(out.box.center[0], out.box.center[1], out.box.center[2]);
    Vec3 half = Vec3::Zero();
    double reach = 0.0, size = 0.0;
    forEachCorner(begin, end, [&](const Vec3& v) {
      half = half.cwiseMax((stored * (v - from)).cwiseAbs());
      reach = std::max(reach, v.norm());
      size = std::max(size, (v - from).norm());
    });
    for (int j = 0; j < 3; ++j) out.box.half[j] = up(half[j] + storage * (size + reach * 0.1));
    out.size = up(size);
    return out;
  }

  template <class Visit>
  void forEachCorner(int begin, int end, Visit&& visit) const {
    for (int i = begin; i < end; ++i)
      for (int k = 0; k < 3; ++k) visit(mesh_.corner(order_[i], k));
  }

  TriangleQuad leaf(int begin, int end) const {
    TriangleQuad leaf{};
    leaf.count = end - begin;
    for (int lane = 0; lane < 4; ++lane) {
      const int t = leaf.triangle[lane] = order_[std::min(begin + lane, end - 1)];
      const Vec3 &a = mesh_.corner(t, 0), &b = mesh_.corner(t, 1), &c = mesh_.corner(t, 2);
      Vec3 normal = (b - a).cross(c - a);
      const double length = normal.norm();
      if (length > 0.0) normal /= length;  // otherwise zero: tells nothing apart
      double radius = 0.0;
      Box along;
      const Vec3 center = (a + b + c) / 3.0;
      for (int k = 0; k < 3; ++k) {
        const Vec3& v = mesh_.corner(t, k);
        along.add(Vec3::Constant(normal.dot(v)));
        radius = std::max(radius, (v - center).norm());
        for (int x = 0; x < 3; ++x) leaf.corner[k][x][lane] = static_cast<float>(v[x]);
      }
      for (int x = 0; x < 3; ++x) {
        leaf.normal[x][lane] = static_cast<float>(normal[x]);
        leaf.center[x][lane] = static_cast<float>(center[x]);
      }
      leaf.lo[lane] = static_cast<float>(along.lo[0]);
      leaf.hi[lane] = static_cast<float>(along.hi[0]);
      leaf.radius[lane] = up(radius);
    }
    return leaf;
  }

  MeshTree& tree_;
  const TriangleMesh& mesh_;
  std::vector<int> order_;
  std::vector<Vec3> centroid_;
};

/// One vertex of every connected component (union-find over the triangles).
std::vector<int> componentSamples(const TriangleMesh& mesh) {
  std::vector<int> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Triangle& t : mesh.triangles)
    for (int k = 1; k < 3; ++k) {
      const int a = root(t[0]), b = root(t[k]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  std::vector<int> samples;
  for (const Triangle& t : mesh.triangles)
    for (int v : t)
      if (root(v) == v) samples.push_back(v);
  std::sort(samples.begin(), samples.end());
  samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
  return samples;
}

const TriangleMesh& notEmpty(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) throw MeshError("a mesh without triangles has no hierarchy");
  return mesh;
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
  TreeBuilder{*this};

  Box box;
  reach = 0.0;
  for (const Triangle& t : mesh.triangles)
    for (int v : t) {
      box.add(mesh.vertices[v]);
      reach = std::max(reach, mesh.vertices[v].norm());
    }
  center = box.center();
  radius = 0.0;
  for (const Triangle& t : mesh.triangles)
    for (int v : t) radius = std::max(radius, (mesh.vertices[v] - center).norm());
  volume = std::abs(signedVolume(mesh));
  centroid = volumeCentroid(mesh, center);
  samples = componentSamples(mesh);
}

double largestStretch(const Mat3& linear) {
  return std::sqrt((linear.transpose() * linear).cwiseAbs().rowwise().sum().maxCoeff());
}

}  // namespace packmesh
