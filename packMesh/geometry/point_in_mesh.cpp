// SPDX-License-Identifier: AGPL-3.0-or-later
#include <array>
#include <cmath>

#include "packMesh/error.h"
#include "packMesh/geometry/mesh_hierarchy.h"
#include "packMesh/geometry/mesh_intersection.h"
#include "packMesh/geometry/triangle_intersection.h"

namespace packmesh {

namespace {

/// A segment in the body frame, to cull the boxes it does not come near.
struct BodySegment {
  float middle[3], half[3], length, rounding;

  BodySegment(const Vec3& p, const Vec3& q, const MeshTree& tree) {
    for (int k = 0; k < 3; ++k) {
      middle[k] = static_cast<float>(0.5 * (p[k] + q[k]));
      half[k] = static_cast<float>(0.5 * (q[k] - p[k]));
    }
    length = static_cast<float>(0.5 * (q - p).norm());
    rounding = 4e-6f * static_cast<float>(tree.reach + p.norm() + q.norm());
  }

  /// Lanes are 0 where the segment passes by: separating axes are those of the box and their cross products
  /// with the segment.
  Int4 near(const BoxQuad& quad) const {
    Float4 offset[3], along[3], step[3], reach[3];
    for (int k = 0; k < 3; ++k) offset[k] = middle[k] - quad.center[k];
    Int4 near = {-1, -1, -1, -1};
    for (int j = 0; j < 3; ++j) {
      along[j] = dot(offset, quad.axis[j]);
      step[j] = dot(half, quad.axis[j]);
      reach[j] = quad.half[j] + rounding;
      near &= abs(along[j]) <= reach[j] + abs(step[j]);
    }
    for (int j = 0; j < 3; ++j) {
      const int k = (j + 1) % 3, l = (j + 2) % 3;
      near &= abs(along[k] * step[l] - along[l] * step[k]) <=
              reach[k] * abs(step[l]) + reach[l] * abs(step[k]) + rounding * length;
    }
    return near;
  }
};

enum class Verdict { outside, inside, onSurface, undecided };

/// Counts the triangles that the segment from p to q crosses; undecided when it meets one in any other way.
Verdict castSegment(const MeshTree& tree, const Placement& placement, const Vec3& p, const Vec3& q,
                    const BodySegment& segment) {
  bool inside = false, clean = true;
  std::array<int, 256> stack;
  int size = 0;
  stack[size++] = tree.boxes[0].content;
  while (size > 0) {
    const int content = stack[--size];
    if (content >= 0) {
      const BoxQuad& quad = tree.quads[content];
      const Int4 near = segment.near(quad);
      for (int lane = 0; lane < 4; ++lane)
        if (quad.box[lane] >= 0 && near[lane]) stack[size++] = tree.boxes[quad.box[lane]].content;
      continue;
    }
    const TriangleQuad& leaf = tree.leaves[~content];
    for (int k = 0; k < leaf.count; ++k) {
      const Vec3 a = placement(tree.mesh.corner(leaf.triangle[k], 0)),
                 b = placement(tree.mesh.corner(leaf.triangle[k], 1)),
                 c = placement(tree.mesh.corner(leaf.triangle[k], 2));
      if (segmentCrossesTriangle(p, q, a, b, c))
        inside = !inside;
      else if (segmentMeetsTriangle(p, q, a, b, c)) {
        if (segmentMeetsTriangle(p, p, a, b, c)) return Verdict::onSurface;
        clean = false;  // through an edge or a vertex; go on, p may still lie on another triangle
      }
    }
  }
  return !clean ? Verdict::undecided : inside ? Verdict::inside : Verdict::outside;
}

/// The k-th of a sequence of directions that spread evenly and are aligned with nothing.
Vec3 castDirection(int k) {
  const double golden = 0.6180339887498949;
  const double z = 2.0 * std::fmod(0.2718281828 + golden * k, 1.0) - 1.0,
               angle = 0.1234567 + 2.3999632297 * k;
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

}  // namespace

bool isInside(const Vec3& p, const MeshHierarchy& mesh, const Placement& placement) {
  const MeshTree& tree = mesh.tree();
  const Sphere sphere = boundingSphere(mesh, placement);
  const double fromCenter = (p - sphere.center).norm();
  if (fromCenter > sphere.radius) return false;
  const Mat3 inverse = placement.linear.inverse();
  const auto toBody = [&](const Vec3& x) -> Vec3 { return inverse * (x - placement.translation); };
  // Each direction is degenerate for a null set of points only: a few thousand in a row mean a broken mesh.
  for (int attempt = 0; attempt < 4096; ++attempt) {
    const Vec3 q = p + 1.5 * (fromCenter + sphere.radius) * castDirection(attempt);
    const Verdict verdict = castSegment(tree, placement, p, q, BodySegment(toBody(p), toBody(q), tree));
    if (verdict != Verdict::undecided) return verdict != Verdict::outside;
  }
  throw MeshError("inside or outside of a mesh cannot be told: it is degenerate");
}

}  // namespace packmesh
