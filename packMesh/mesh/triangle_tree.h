// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Search for triangles of a mesh near a box, a point or each other.
#pragma once

#include <utility>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// A tree of axis-aligned boxes over the triangles of a fixed mesh. Boxes are exact and closed: boxes that
/// share a single point meet, and no intersection is missed.
class TriangleTree {
 public:
  explicit TriangleTree(const TriangleMesh& mesh);

  /// Calls `visit(t)` for every triangle whose bounding box meets `box`.
  template <class Visit>
  void forEachNear(const Box& box, Visit&& visit) const {
    int stack[64], top = 0;
    if (!nodes_.empty()) stack[top++] = 0;
    while (top > 0) {
      const Node& node = nodes_[stack[--top]];
      if (!node.box.meets(box)) continue;
      if (node.count == 0) {
        stack[top++] = node.first;
        stack[top++] = node.first + 1;
      } else {
        for (int e = node.first; e < node.first + node.count; ++e)
          if (boxes_[e].meets(box)) visit(order_[e]);
      }
    }
  }

  /// Calls `visit(t)` for every triangle whose bounding box is nearer to `p` than the bound, roughly in
  /// ascending order of distance. `visit` returns the new bound (squared [µm²]); `bound` is the initial one.
  template <class Visit>
  void visitNearer(const Vec3& p, double bound, Visit&& visit) const {
    struct Waiting {
      double squared;
      int node;
    } stack[64];
    int top = 0;
    if (!nodes_.empty()) stack[top++] = {nodes_[0].box.squaredDistance(p), 0};
    while (top > 0) {
      const Waiting next = stack[--top];
      if (!(next.squared < bound)) continue;
      const Node& node = nodes_[next.node];
      if (node.count == 0) {
        Waiting near{nodes_[node.first].box.squaredDistance(p), node.first};
        Waiting far{nodes_[node.first + 1].box.squaredDistance(p), node.first + 1};
        if (far.squared < near.squared) std::swap(near, far);
        if (far.squared < bound) stack[top++] = far;
        if (near.squared < bound) stack[top++] = near;
      } else {
        for (int e = node.first; e < node.first + node.count; ++e)
          if (boxes_[e].squaredDistance(p) < bound) bound = visit(order_[e]);
      }
    }
  }

  /// Calls `visit(s, t)` once for every two triangles whose bounding boxes meet, until it returns false.
  /// Triangles with a common vertex are left out if they certainly are in different directions from it: they
  /// have nothing but that vertex in common. (The boxes of all triangles of a fan meet.)
  /// @param mesh the mesh of the tree
  template <class Visit>
  void forEachPair(const TriangleMesh& mesh, Visit&& visit) const {
    const std::vector<Fan> fans = fansIn(mesh);
    std::vector<std::pair<int, int>> stack;
    if (!nodes_.empty()) stack.emplace_back(0, 0);
    while (!stack.empty()) {
      const auto [i, j] = stack.back();
      stack.pop_back();
      const Node &a = nodes_[i], &b = nodes_[j];
      if (i == j && a.count == 0) {
        stack.insert(stack.end(), {{a.first, a.first}, {a.first + 1, a.first + 1}, {a.first, a.first + 1}});
      } else if (i == j) {
        for (int e = a.first; e < a.first + a.count; ++e)
          for (int f = e + 1; f < a.first + a.count; ++f)
            if (boxes_[e].meets(boxes_[f]) && !visit(order_[e], order_[f])) return;
      } else if (a.box.meets(b.box)) {
        if (fans[i].vertex >= 0 && fans[i].vertex == fans[j].vertex &&
            !fans[i].directions.meets(fans[j].directions))
          continue;
        if (a.count > 0 && b.count > 0) {
          for (int e = a.first; e < a.first + a.count; ++e)
            for (int f = b.first; f < b.first + b.count; ++f)
              if (boxes_[e].meets(boxes_[f]) && !visit(order_[e], order_[f])) return;
        } else if (b.count > 0 || (a.count == 0 && a.box.size().squaredNorm() > b.box.size().squaredNorm())) {
          stack.insert(stack.end(), {{a.first, j}, {a.first + 1, j}});
        } else {
          stack.insert(stack.end(), {{i, b.first}, {i, b.first + 1}});
        }
      }
    }
  }

 private:
  struct Node {
    Box box;
    int first;  ///< first of its two children, or of its triangles in order_
    int count;  ///< number of triangles; 0: the node has children
  };

  /// What the triangles of a node have in common.
  struct Fan {
    int vertex = -1;  ///< a vertex of all of them, that of the most triangles if there are several; -1: none
    Box directions;   ///< contains the unit vectors from it to their other points
  };
  std::vector<Fan> fansIn(const TriangleMesh& mesh) const;

  std::vector<Node> nodes_;
  std::vector<int> order_;
  std::vector<Box> boxes_;  ///< boxes of the triangles, in the order of order_
};

}  // namespace packmesh
