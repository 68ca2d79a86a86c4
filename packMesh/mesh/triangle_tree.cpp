// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "packMesh/core/poll.h"

namespace packmesh {

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
