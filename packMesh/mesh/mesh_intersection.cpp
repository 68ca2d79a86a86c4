// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/mesh_intersection.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "packMesh/core/error.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/convex_hull.h"
#include "packMesh/mesh/mesh_kernels.h"
#include "packMesh/mesh/mesh_tree.h"
#include "packMesh/mesh/predicates.h"
#include "packMesh/mesh/triangle_pair.h"

namespace packmesh {

namespace {

/// Relative error, with respect to the largest term, of a number computed in floats by some tens of
/// operations.
constexpr double floatRounding = 64.0 * 5.97e-8;

/// Map from the body frame of the second mesh to that of the first: x -> linear·x + translation.
struct View {
  Mat3 linear;
  Vec3 translation;
  SeenFrom floats;
  double worldPerUnit;    ///< lower bound of world distance / distance in this frame
  double rounding;        ///< upper bound of the error of distances in floats [units of the frame]
  double doubleRounding;  ///< the same for doubles

  View(const MeshTree& first, const Placement& firstPlacement, const MeshTree& second,
       const Placement& secondPlacement) {
    const Mat3 inverse = firstPlacement.linear.inverse();
    linear = inverse * secondPlacement.linear;
    translation = inverse * (secondPlacement.translation - firstPlacement.translation);
    const Mat3 normals = linear.inverse().transpose();
    const double stretch = largestStretch(linear), tallest = largestStretch(normals),
                 compression = largestStretch(inverse);
    for (int i = 0; i < 3; ++i) {
      floats.shift[i] = static_cast<float>(translation[i]);
      for (int j = 0; j < 3; ++j) {
        floats.point[i][j] = static_cast<float>(linear(i, j));
        floats.direction[i][j] = static_cast<float>(normals(i, j) / tallest);
      }
    }
    floats.stretch = static_cast<float>(stretch);
    floats.slab = static_cast<float>(1.0 / tallest);
    floats.skew = static_cast<float>(stretch * stretch * tallest * tallest);
    worldPerUnit = (1.0 - 1024.0 * 1.2e-16) / compression;  // about a hundred roundings of doubles
    // World vertices are rounded too: tolerance::culling for coordinates below 1e5 µm.
    const double size = first.reach + stretch * second.reach + translation.norm();
    doubleRounding = 1e-10 * size + compression * (tolerance::culling +
                                                   1e-14 * (firstPlacement.translation.cwiseAbs().sum() +
                                                            secondPlacement.translation.cwiseAbs().sum()));
    rounding = floatRounding * size + doubleRounding;
  }
};

/// One test of two placed meshes.
class PairTest {
 public:
  PairTest(const MeshTree& first, const Placement& firstPlacement, const MeshTree& second,
           const Placement& secondPlacement, double gapOfInterest)
      : first_(first),
        second_(second),
        firstPlacement_(firstPlacement),
        secondPlacement_(secondPlacement),
        view_(first, firstPlacement, second, secondPlacement),
        measure_(gapOfInterest > 0.0),
        best_(gapOfInterest) {}

  bool hullsApart() const {
    if (first_.hull.points().empty() || second_.hull.points().empty()) return false;
    const Vec3 between = first_.center - (view_.linear * second_.center + view_.translation);
    // The gradient of the contact function of two ellipsoids at λ = 1/2 (J. Perram, M. Wertheim, J. Comput.
    // Phys. 58, 1985): the hulls of most pairs are apart along it.
    const Mat3 spread = first_.spread + view_.linear * second_.spread * view_.linear.transpose();
    const Vec3 normal = spread.inverse() * between;
    const Vec3 direction = normal.isZero(0.0) || !normal.allFinite() ? Vec3(Vec3::UnitX()) : normal;
    return packmesh::hullsApart(first_.hull, second_.hull, view_.linear, view_.translation, direction,
                                best_ / view_.worldPerUnit, view_.doubleRounding);
  }

  /// True if any triangles meet. Otherwise gap() is known afterwards.
  bool meet() {
    const auto examineOne = [](void* self, int a, int b, bool mayMeet) {
      return static_cast<PairTest*>(self)->examine(a, b, mayMeet);
    };
    const TreeView a = viewOf(first_), b = viewOf(second_);
    static PairSearch* const search = pairSearch(chosenInstructionSet());
    return !search(a, b, view_.floats, static_cast<float>(view_.rounding), limit(), examineOne, this);
  }

  double gap() const { return best_; }

 private:
  static TreeView viewOf(const MeshTree& tree) {
    return {tree.quads.data(), reinterpret_cast<const float(*)[3]>(tree.vertices.data()),
            reinterpret_cast<const int(*)[3]>(tree.mesh->triangles.data()), tree.discs.data()};
  }

  /// Pairs further apart than this are irrelevant: best_ or more [frame of the first].
  float limit() const {
    return std::nextafter(static_cast<float>(best_ / view_.worldPerUnit),
                          std::numeric_limits<float>::infinity());
  }

  /// Returns the new limit; negative if the triangles meet.
  float examine(int a, int b, bool mayMeet) {
    const TriangleMesh &first = *first_.mesh, &second = *second_.mesh;
    const Vec3 p[3] = {firstPlacement_(first.corner(a, 0)), firstPlacement_(first.corner(a, 1)),
                       firstPlacement_(first.corner(a, 2))};
    const Vec3 q[3] = {secondPlacement_(second.corner(b, 0)), secondPlacement_(second.corner(b, 1)),
                       secondPlacement_(second.corner(b, 2))};
    if (mayMeet && trianglesMeet(p[0], p[1], p[2], q[0], q[1], q[2])) return -1.0f;
    if (measure_) best_ = std::min(best_, triangleDistance(p[0], p[1], p[2], q[0], q[1], q[2]));
    return limit();
  }

  const MeshTree &first_, &second_;
  const Placement &firstPlacement_, &secondPlacement_;
  View view_;
  bool measure_;
  double best_;  ///< smallest gap found so far, or gapOfInterest [µm]
};

double placedVolume(const MeshTree& tree, const Placement& placement) {
  return tree.volume * std::abs(placement.linear.determinant());
}

/// True if `inner` could lie entirely inside `outer`, by volumes and centroids: the part of `outer` outside
/// `inner` must balance the distance between their centroids.
bool couldContain(const MeshHierarchy& outer, const Placement& outerPlacement, const MeshHierarchy& inner,
                  const Placement& innerPlacement) {
  const MeshTree &o = outer.tree(), &i = inner.tree();
  // Volumes say nothing where a deformed mesh intersects itself, turned inside out.
  const bool deformed = o.hull.points().empty() || i.hull.points().empty();
  if (deformed || o.samples.size() > 1 || i.samples.size() > 1) return true;
  constexpr double relative = 1e-9;  // volumes and centroids are more accurate than this
  const double outerVolume = placedVolume(o, outerPlacement), innerVolume = placedVolume(i, innerPlacement);
  const double rest = outerVolume * (1.0 + relative) - innerVolume;
  if (rest < 0.0) return false;
  const Sphere sphere = boundingSphere(outer, outerPlacement);
  const double offset = (outerPlacement(o.centroid) - innerPlacement(i.centroid)).norm();
  const double slack = relative * (sphere.radius + sphere.center.norm());
  return (offset - slack) * outerVolume <= rest * 2.0 * sphere.radius;
}

/// Position of `inner`, which meets no triangle of `outer`: not inside, partly inside, or entirely inside.
enum class Containment { none, partly, wholly };
Containment containment(const MeshHierarchy& outer, const Placement& outerPlacement,
                        const MeshHierarchy& inner, const Placement& innerPlacement) {
  if (!couldContain(outer, outerPlacement, inner, innerPlacement)) return Containment::none;
  std::size_t inside = 0;
  for (int v : inner.tree().samples)
    inside += isInside(innerPlacement(inner.mesh().vertices[v]), outer, outerPlacement);
  return inside == 0                             ? Containment::none
         : inside == inner.tree().samples.size() ? Containment::wholly
                                                 : Containment::partly;
}

}  // namespace

Sphere boundingSphere(const MeshHierarchy& mesh, const Placement& placement) {
  return boundingSphere(Sphere{mesh.tree().center, mesh.tree().radius}, placement);
}

Sphere boundingSphere(const Sphere& ofBody, const Placement& placement) {
  const Vec3 center = placement(ofBody.center);
  // Some tens of roundings of doubles in the centre and the radius.
  const double rounding = tolerance::culling + 1e-14 * center.cwiseAbs().sum();
  return {center, ofBody.radius * largestStretch(placement.linear) * (1.0 + 1e-12) + rounding};
}

MeshPairResult relate(const MeshHierarchy& first, const Placement& firstPlacement,
                      const MeshHierarchy& second, const Placement& secondPlacement, double gapOfInterest) {
  MeshPairResult result;
  const Sphere a = boundingSphere(first, firstPlacement), b = boundingSphere(second, secondPlacement);
  const double reach = a.radius + b.radius + gapOfInterest;
  if ((a.center - b.center).squaredNorm() > reach * reach) return result;

  PairTest test(first.tree(), firstPlacement, second.tree(), secondPlacement, gapOfInterest);
  if (test.hullsApart()) return result;
  if (test.meet()) {
    result.relation = MeshRelation::meet;
    result.gap = 0.0;
    return result;
  }
  const Containment firstInside = containment(second, secondPlacement, first, firstPlacement);
  const Containment secondInside = containment(first, firstPlacement, second, secondPlacement);
  if (firstInside == Containment::wholly)
    result.relation = MeshRelation::firstInside;
  else if (secondInside == Containment::wholly)
    result.relation = MeshRelation::secondInside;
  else if (firstInside == Containment::partly || secondInside == Containment::partly)
    result.relation = MeshRelation::meet;
  if (result.relation != MeshRelation::apart)
    result.gap = 0.0;
  else if (test.gap() < gapOfInterest)
    result.gap = test.gap();
  return result;
}

double surfaceGap(const MeshHierarchy& first, const Placement& firstPlacement, const MeshHierarchy& second,
                  const Placement& secondPlacement, double gapOfInterest) {
  PairTest test(first.tree(), firstPlacement, second.tree(), secondPlacement, gapOfInterest);
  if (test.meet()) return 0.0;
  return test.gap() < gapOfInterest ? test.gap() : std::numeric_limits<double>::infinity();
}

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
      const Vec3 a = placement(tree.mesh->corner(t, 0)), b = placement(tree.mesh->corner(t, 1)),
                 c = placement(tree.mesh->corner(t, 2));
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
