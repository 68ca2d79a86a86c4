// SPDX-License-Identifier: AGPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>

#include "packMesh/core/error.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/mesh_tree.h"
#include "packMesh/mesh/predicates.h"
#include "packMesh/mesh/triangle_intersection.h"

namespace packmesh {

namespace {

/// A segment in the body frame, for culling discs.
struct BodySegment {
  float middle[3], half[3], halfSquared, rounding;

  BodySegment(const Vec3& p, const Vec3& q, const MeshTree& tree) {
    for (int k = 0; k < 3; ++k) {
      middle[k] = static_cast<float>(0.5 * (p[k] + q[k]));
      half[k] = static_cast<float>(0.5 * (q[k] - p[k]));
    }
    halfSquared = dot(half, half);
    // About sixty roundings of floats.
    rounding = 4e-6f * static_cast<float>(tree.reach + p.norm() + q.norm());
  }

  /// True if the segment could meet a disc: it must meet the disc's sphere and slab.
  bool near(const DiscQuad& quad, int lane) const {
    float offset[3], normal[3];
    for (int k = 0; k < 3; ++k) {
      offset[k] = quad.discs.center[k][lane] - middle[k];
      normal[k] = quad.discs.normal[k][lane];
    }
    if (std::abs(dot(offset, normal)) > quad.discs.half[lane] + std::abs(dot(half, normal)) + rounding)
      return false;
    const float t = std::clamp(dot(offset, half) / halfSquared, -1.0f, 1.0f),
                reach = quad.discs.radius[lane] + rounding;
    for (int k = 0; k < 3; ++k) offset[k] -= t * half[k];
    return dot(offset, offset) <= reach * reach;
  }

 private:
  static float dot(const float* a, const float* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
};

enum class Verdict { outside, inside, onSurface, undecided };

/// By the winding number of the surface around p: the triangles crossed by the segment from p to q, which is
/// outside, from within less those crossed from outside. Undecided if it meets one in any other way.
Verdict castSegment(const MeshTree& tree, const Placement& placement, const Vec3& p, const Vec3& q,
                    const BodySegment& segment) {
  int winding = 0;
  bool clean = true;
  std::array<int, 256> stack;
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const DiscQuad& quad = tree.quads[stack[--size]];
    for (int lane = 0; lane < 4; ++lane) {
      if (quad.discs.half[lane] < 0.0f || !segment.near(quad, lane)) continue;
      if (quad.content[lane] >= 0) {
        stack[size++] = quad.content[lane];
        continue;
      }
      const int t = ~quad.content[lane];
      const Vec3 a = placement(tree.mesh.corner(t, 0)), b = placement(tree.mesh.corner(t, 1)),
                 c = placement(tree.mesh.corner(t, 2));
      if (segmentCrossesTriangle(p, q, a, b, c))
        winding -= sideOfPlane(a, b, c, p);
      else if (segmentMeetsTriangle(p, q, a, b, c)) {
        if (segmentMeetsTriangle(p, p, a, b, c)) return Verdict::onSurface;
        clean = false;  // through an edge or a vertex; continue, since p could lie on another triangle
      }
    }
  }
  return !clean ? Verdict::undecided : winding != 0 ? Verdict::inside : Verdict::outside;
}

/// The k-th of a sequence of evenly spread directions that are not aligned with any axis.
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
  // Each direction is degenerate only for a null set of points: thousands of failures in a row mean an
  // invalid mesh.
  for (int attempt = 0; attempt < 4096; ++attempt) {
    const Vec3 q = p + 1.5 * (fromCenter + sphere.radius) * castDirection(attempt);
    const Verdict verdict = castSegment(tree, placement, p, q, BodySegment(toBody(p), toBody(q), tree));
    if (verdict != Verdict::undecided) return verdict != Verdict::outside;
  }
  throw MeshError("cannot decide whether a point is inside the mesh: the mesh is degenerate");
}

}  // namespace packmesh
