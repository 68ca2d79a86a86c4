// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/mesh_intersection.h"

#include <algorithm>
#include <cmath>

#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/hierarchy_kernel.h"
#include "packMesh/mesh/hull_separation.h"
#include "packMesh/mesh/mesh_tree.h"
#include "packMesh/mesh/triangle_distance.h"
#include "packMesh/mesh/triangle_intersection.h"

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
            reinterpret_cast<const int(*)[3]>(tree.mesh.triangles.data()), tree.discs.data()};
  }

  /// Pairs further apart than this are irrelevant: best_ or more [frame of the first].
  float limit() const {
    return std::nextafter(static_cast<float>(best_ / view_.worldPerUnit),
                          std::numeric_limits<float>::infinity());
  }

  /// Returns the new limit; negative if the triangles meet.
  float examine(int a, int b, bool mayMeet) {
    const TriangleMesh &first = first_.mesh, &second = second_.mesh;
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
  const MeshTree& tree = mesh.tree();
  const Vec3 center = placement(tree.center);
  // Some tens of roundings of doubles in the centre and the radius.
  const double rounding = tolerance::culling + 1e-14 * center.cwiseAbs().sum();
  return {center, tree.radius * largestStretch(placement.linear) * (1.0 + 1e-12) + rounding};
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

}  // namespace packmesh
