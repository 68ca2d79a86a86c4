// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Trees over the triangles of a mesh: of discs, four children per node, for pairs of meshes; of boxes,
/// for what is near a box or a point.
///
/// Used only for culling: floats with margins, never a decision. A disc is the intersection of a sphere and
/// the slab between two parallel planes. Thin discs separate patches of two membranes that nearly touch much
/// earlier than boxes of any fixed orientation, and a test of two discs costs a third of one of two oriented
/// boxes.
#pragma once

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "packMesh/mesh/convex_hull.h"
#include "packMesh/mesh/mesh_kernels.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

struct MeshTree;

/// A bounding hierarchy over the triangles of one template mesh, in its body frame; shared by all cells of a
/// species. Bounding volumes are conservative: triangles that meet are never culled.
class MeshHierarchy {
 public:
  /// @throws MeshError if the mesh has no triangles
  explicit MeshHierarchy(const TriangleMesh& mesh);
  /// Of a deformed form of another mesh: made in a tenth of the time, and somewhat slower to use.
  /// @param mesh with the triangles of the other one; shared
  MeshHierarchy(std::shared_ptr<const TriangleMesh> mesh, const MeshHierarchy& undeformed);
  ~MeshHierarchy();
  MeshHierarchy(MeshHierarchy&&) noexcept;
  MeshHierarchy& operator=(MeshHierarchy&&) noexcept;

  const TriangleMesh& mesh() const;
  const MeshTree& tree() const { return *tree_; }  ///< see mesh_tree.h

 private:
  std::unique_ptr<const MeshTree> tree_;
};

/// A mesh and its placement in the world. References only.
struct PlacedHierarchy {
  const MeshHierarchy& hierarchy;
  const Placement& placement;

  std::size_t vertexCount() const { return hierarchy.mesh().vertices.size(); }
  Vec3 vertex(std::size_t i) const { return placement(hierarchy.mesh().vertices[i]); }
};

struct MeshTree {
  std::shared_ptr<const TriangleMesh> mesh;

  std::vector<DiscQuad> quads;                 ///< the first has one lane, which contains the whole mesh
  std::vector<std::array<float, 3>> vertices;  ///< of the mesh [µm]
  std::vector<int> discs;                      ///< position of each triangle's disc (DiscQuad::disc)
  ConvexHull hull;                             ///< empty for a deformed mesh

  Vec3 center;    ///< centre of a sphere around all vertices [µm]
  double radius;  ///< radius of that sphere [µm]
  Mat3 spread;    ///< mean of (v - center)(v - center)ᵀ over the hull's vertices, not singular [µm²]
  double reach;   ///< largest distance of a vertex from the origin of the body frame [µm]
  double volume;  ///< enclosed volume [µm³], >= 0
  Vec3 centroid;  ///< centroid of the enclosed volume [µm]
  std::vector<int> samples;  ///< one vertex of each connected component

  explicit MeshTree(const TriangleMesh& mesh);
  /// Of a deformed form of the mesh of another tree, of which it takes the patches: in a tenth of the time,
  /// with looser discs.
  /// @param mesh with the triangles of the other one
  MeshTree(std::shared_ptr<const TriangleMesh> mesh, const MeshTree& undeformed);

 private:
  void measure();
};

/// Upper bound of the singular values of a linear map (Gershgorin circles of the Gram matrix: sharp for a
/// scaled rotation, valid for every map).
double largestStretch(const Mat3& linear);

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

  /// Calls `visit(t)` for every triangle whose bounding box is nearer to `box` than `distance` [µm], until
  /// `visit` returns false.
  template <class Visit>
  void forEachWithin(const Box& box, double distance, Visit&& visit) const {
    const double squared = distance * distance;
    int stack[64], top = 0;
    if (!nodes_.empty()) stack[top++] = 0;
    while (top > 0) {
      const Node& node = nodes_[stack[--top]];
      if (!(node.box.squaredDistance(box) < squared)) continue;
      if (node.count == 0) {
        stack[top++] = node.first;
        stack[top++] = node.first + 1;
      } else {
        for (int e = node.first; e < node.first + node.count; ++e)
          if (boxes_[e].squaredDistance(box) < squared && !visit(order_[e])) return;
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
