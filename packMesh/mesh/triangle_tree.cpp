// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/triangle_tree.h"

#include <algorithm>
#include <numeric>

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

}  // namespace packmesh
