// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/geometry/mesh_intersection.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "packMesh/geometry/hull_separation.h"
#include "packMesh/geometry/mesh_hierarchy.h"
#include "packMesh/geometry/triangle_distance.h"
#include "packMesh/geometry/triangle_intersection.h"
#include "packMesh/tolerances.h"

namespace packmesh {

namespace {

/// Depth-first stacks: four children replace a node, and trees are balanced.
constexpr int stackSize = 256;

/// Rounding to float of a number computed by some tens of operations, relative to the largest term.
constexpr double floatRounding = 64.0 * 5.97e-8;

/// An oriented box seen from another frame; it may have become a parallelepiped.
struct SeenBox {
  float center[3], axis[3][3], half[3];  ///< centre + sum of s_j axis_j, |s_j| <= half_j
  float extent[3];                       ///< bounds its extent along the axes
};

/// One mesh seen from the body frame of another: x -> linear·x + translation.
struct View {
  Mat3 linear;
  Vec3 translation;
  float point[3][3], shift[3];  ///< the same in floats
  float direction[3][3];        ///< linear / stretch: unit vectors become no longer than 1
  float stretch;
  float skew;             ///< bounds the cosines between directions of axes that were orthogonal
  double worldPerUnit;    ///< a distance in this frame is at least that many times longer in the world
  double rounding;        ///< bounds the error of distances computed in floats [units of the frame]
  double doubleRounding;  ///< the same, computed in doubles

  View(const MeshTree& of, const Placement& ofPlacement, const MeshTree& from,
       const Placement& fromPlacement) {
    const Mat3 inverse = fromPlacement.linear.inverse();
    linear = inverse * ofPlacement.linear;
    translation = inverse * (ofPlacement.translation - fromPlacement.translation);
    const double k = largestStretch(linear), compression = largestStretch(inverse);
    stretch = static_cast<float>(k);
    const Mat3 gram = linear.transpose() * linear / (k * k) - Mat3::Identity();
    skew = static_cast<float>(gram.cwiseAbs().rowwise().sum().maxCoeff());
    for (int i = 0; i < 3; ++i) {
      shift[i] = static_cast<float>(translation[i]);
      for (int j = 0; j < 3; ++j) {
        point[i][j] = static_cast<float>(linear(i, j));
        direction[i][j] = static_cast<float>(linear(i, j) / k);
      }
    }
    worldPerUnit = (1.0 - 1024.0 * 1.2e-16) / compression;
    // World vertices are rounded too: tolerance::culling as long as coordinates keep below 1e5 µm.
    const double size = from.reach + k * of.reach + translation.norm();
    doubleRounding = 1e-10 * size + compression * (tolerance::culling +
                                                   1e-14 * (ofPlacement.translation.cwiseAbs().sum() +
                                                            fromPlacement.translation.cwiseAbs().sum()));
    rounding = floatRounding * size + doubleRounding;
  }

  SeenBox seen(const OrientedBox& box) const {
    SeenBox out;
    const float skewed = skew * stretch * (box.half[0] + box.half[1] + box.half[2]);
    for (int i = 0; i < 3; ++i) {
      out.center[i] =
          point[i][0] * box.center[0] + point[i][1] * box.center[1] + point[i][2] * box.center[2] + shift[i];
      out.half[i] = box.half[i] * stretch;
      out.extent[i] = out.half[i] + skewed;
      for (int j = 0; j < 3; ++j)
        out.axis[j][i] = direction[i][0] * box.axis[j][0] + direction[i][1] * box.axis[j][1] +
                         direction[i][2] * box.axis[j][2];
    }
    return out;
  }
};

/// Lower bounds of the distances between one box and four: the largest separation along the axes of either
/// (no cross products of axes: they seldom decide, Gottschalk et al. 1996).
Float4 separation(const SeenBox& one, const BoxQuad& four) {
  Float4 offset[3], cosine[3][3];
  for (int k = 0; k < 3; ++k) offset[k] = one.center[k] - four.center[k];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) cosine[i][j] = abs(dot(one.axis[i], four.axis[j]));
  Float4 most = splat(-1e30f);
  for (int j = 0; j < 3; ++j)
    most =
        max(most, abs(dot(offset, four.axis[j])) - four.half[j] -
                      (cosine[0][j] * one.half[0] + cosine[1][j] * one.half[1] + cosine[2][j] * one.half[2]));
  for (int i = 0; i < 3; ++i)
    most = max(most,
               abs(dot(one.axis[i], offset)) - one.extent[i] -
                   (cosine[i][0] * four.half[0] + cosine[i][1] * four.half[1] + cosine[i][2] * four.half[2]));
  return most;
}

/// The triangles of a leaf seen from another frame, lane by lane.
struct SeenTriangles {
  Float4 corner[3][3], normal[3], lo, hi, center[3], radius;

  SeenTriangles(const TriangleQuad& leaf, const View& view) {
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) corner[k][i] = dot(view.point[i], leaf.corner[k]) + view.shift[i];
    for (int i = 0; i < 3; ++i) {
      normal[i] = dot(view.direction[i], leaf.normal);
      center[i] = dot(view.point[i], leaf.center) + view.shift[i];
    }
    const Float4 a = dot(normal, corner[0]), b = dot(normal, corner[1]), c = dot(normal, corner[2]);
    lo = min(min(a, b), c);
    hi = max(max(a, b), c);
    radius = leaf.radius * view.stretch;
  }
};

/// Lower bounds of the distances between one triangle (lane `l` of `seen`) and the four of `leaf`: separation
/// along the normals of either. Pairs whose bounding spheres are further apart than `limit` get 1e30.
Float4 separation(const SeenTriangles& seen, int l, const TriangleQuad& leaf, float limit) {
  Float4 offset[3];
  float corner[3][3], normal[3];
  for (int i = 0; i < 3; ++i) {
    offset[i] = seen.center[i][l] - leaf.center[i];
    normal[i] = seen.normal[i][l];
    for (int k = 0; k < 3; ++k) corner[k][i] = seen.corner[k][i][l];
  }
  Float4 a = dot(corner[0], leaf.normal), b = dot(corner[1], leaf.normal), c = dot(corner[2], leaf.normal);
  Float4 most = max(min(min(a, b), c) - leaf.hi, leaf.lo - max(max(a, b), c));
  a = dot(normal, leaf.corner[0]), b = dot(normal, leaf.corner[1]), c = dot(normal, leaf.corner[2]);
  most = max(most, max(min(min(a, b), c) - seen.hi[l], seen.lo[l] - max(max(a, b), c)));
  const Float4 touch = leaf.radius + (seen.radius[l] + limit);
  return dot(offset, offset) > touch * touch ? splat(1e30f) : most;
}

/// The traversal of two trees.
class PairTest {
 public:
  PairTest(const MeshTree& first, const Placement& firstPlacement, const MeshTree& second,
           const Placement& secondPlacement, double gapOfInterest)
      : first_(first),
        second_(second),
        firstPlacement_(firstPlacement),
        secondPlacement_(secondPlacement),
        secondFromFirst_(second, secondPlacement, first, firstPlacement),
        firstFromSecond_(first, firstPlacement, second, secondPlacement),
        measure_(gapOfInterest > 0.0),
        best_(gapOfInterest) {
    limitTo(gapOfInterest);
  }

  bool hullsApart() const {
    const View& view = secondFromFirst_;
    const Vec3 between = first_.center - (view.linear * second_.center + view.translation);
    const Vec3 direction = between.isZero(0.0) ? Vec3(Vec3::UnitX()) : between;
    return packmesh::hullsApart(first_.hull, second_.hull, view.linear, view.translation, direction,
                                firstLimit_, view.doubleRounding);
  }

  /// Whether any triangles meet. Otherwise gap() is known afterwards.
  bool meet() {
    std::array<Entry, stackSize> stack;
    int size = 0;
    stack[size++] = {0, 0, 0.0f};
    while (size > 0) {
      const Entry entry = stack[--size];
      if (entry.apart > limit_) continue;
      const TreeBox &a = first_.boxes[entry.first], &b = second_.boxes[entry.second];
      if (a.content < 0 && b.content < 0) {
        if (trianglesMeetIn(first_.leaves[~a.content], second_.leaves[~b.content])) return true;
        continue;
      }
      const bool descendFirst =
          b.content < 0 || (a.content >= 0 && a.size >= b.size * secondFromFirst_.stretch);
      const BoxQuad& quad = descendFirst ? first_.quads[a.content] : second_.quads[b.content];
      const View& view = descendFirst ? secondFromFirst_ : firstFromSecond_;
      const Float4 apart =
          separation(view.seen(descendFirst ? b.box : a.box), quad) * static_cast<float>(view.worldPerUnit);
      const float rounding = static_cast<float>(view.rounding * view.worldPerUnit);
      const int start = size;
      for (int lane = 0; lane < 4; ++lane) {
        if (quad.box[lane] < 0 || apart[lane] - rounding > limit_) continue;
        Entry child = entry;
        (descendFirst ? child.first : child.second) = quad.box[lane];
        child.apart = apart[lane] - rounding;
        int at = size++;  // the nearest on top: it lowers the limit for the others
        for (; at > start && stack[at - 1].apart < child.apart; --at) stack[at] = stack[at - 1];
        stack[at] = child;
      }
    }
    return false;
  }

  double gap() const { return best_; }

 private:
  struct Entry {
    int first, second;
    float apart;  ///< lower bound of their distance [µm]
  };

  void limitTo(double gap) {
    limit_ = std::nextafter(static_cast<float>(gap), std::numeric_limits<float>::infinity());
    firstLimit_ = gap / secondFromFirst_.worldPerUnit;
  }

  bool trianglesMeetIn(const TriangleQuad& a, const TriangleQuad& b) {
    const View& view = secondFromFirst_;
    const SeenTriangles seen(b, view);
    const float rounding = static_cast<float>(view.rounding);
    for (int l = 0; l < b.count; ++l) {
      const Float4 apart = separation(seen, l, a, static_cast<float>(firstLimit_) + rounding) - rounding;
      for (int k = 0; k < a.count; ++k)
        if (!(apart[k] > static_cast<float>(firstLimit_)) &&
            examine(a.triangle[k], b.triangle[l], !(apart[k] > 0.0f)))
          return true;
    }
    return false;
  }

  bool examine(int a, int b, bool mayMeet) {
    const TriangleMesh &first = first_.mesh, &second = second_.mesh;
    const Vec3 p[3] = {firstPlacement_(first.corner(a, 0)), firstPlacement_(first.corner(a, 1)),
                       firstPlacement_(first.corner(a, 2))};
    const Vec3 q[3] = {secondPlacement_(second.corner(b, 0)), secondPlacement_(second.corner(b, 1)),
                       secondPlacement_(second.corner(b, 2))};
    if (mayMeet && trianglesMeet(p[0], p[1], p[2], q[0], q[1], q[2])) return true;
    if (!measure_) return false;
    const double gap = triangleDistance(p[0], p[1], p[2], q[0], q[1], q[2]);
    if (gap < best_) {
      best_ = gap;
      limitTo(gap);
    }
    return false;
  }

  const MeshTree &first_, &second_;
  const Placement &firstPlacement_, &secondPlacement_;
  View secondFromFirst_, firstFromSecond_;
  bool measure_;
  double best_;        ///< smallest gap found so far, or gapOfInterest [µm]
  float limit_;        ///< pairs further apart than this are of no interest: best_ as a float, or above [µm]
  double firstLimit_;  ///< the same in the frame of the first
};

double placedVolume(const MeshTree& tree, const Placement& placement) {
  return tree.volume * std::abs(placement.linear.determinant());
}

/// Whether `inner` could lie wholly inside `outer`, by volumes and centroids: what is left of `outer` around
/// `inner` must balance the distance between their centroids.
bool couldContain(const MeshHierarchy& outer, const Placement& outerPlacement, const MeshHierarchy& inner,
                  const Placement& innerPlacement) {
  const MeshTree &o = outer.tree(), &i = inner.tree();
  if (o.samples.size() > 1 || i.samples.size() > 1) return true;
  constexpr double relative = 1e-9;  // volumes and centroids are better known than this
  const double outerVolume = placedVolume(o, outerPlacement), innerVolume = placedVolume(i, innerPlacement);
  const double rest = outerVolume * (1.0 + relative) - innerVolume;
  if (rest < 0.0) return false;
  const Sphere sphere = boundingSphere(outer, outerPlacement);
  const double offset = (outerPlacement(o.centroid) - innerPlacement(i.centroid)).norm();
  const double slack = relative * (sphere.radius + sphere.center.norm());
  return (offset - slack) * outerVolume <= rest * 2.0 * sphere.radius;
}

/// Whether `inner`, which meets no triangle of `outer`, lies inside it, in part or wholly.
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

MeshHierarchy::MeshHierarchy(const TriangleMesh& mesh) : tree_(std::make_unique<MeshTree>(mesh)) {}
MeshHierarchy::~MeshHierarchy() = default;
MeshHierarchy::MeshHierarchy(MeshHierarchy&&) noexcept = default;
MeshHierarchy& MeshHierarchy::operator=(MeshHierarchy&&) noexcept = default;

const TriangleMesh& MeshHierarchy::mesh() const {
  return tree_->mesh;
}

Sphere boundingSphere(const MeshHierarchy& mesh, const Placement& placement) {
  const MeshTree& tree = mesh.tree();
  const Vec3 center = placement(tree.center);
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

}  // namespace packmesh
