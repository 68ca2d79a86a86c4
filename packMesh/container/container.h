// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Interface of containers and of their walls.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/field/sampled_distance.h"
#include "packMesh/mesh/mesh_tree.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Distance to the wall at one point: positive inside the lumen [µm], gradient pointing into the lumen.
/// Precise where |distance| is below about a micrometre, of the right sign and a lower bound of the distance
/// within `Wall::slack()` further away.
using WallDistance = DistanceSample;

/// A round wall, planes perpendicular to the axes, or both: cylinders, spheres, boxes, also with periodic
/// axes.
struct ClosedFormWall {
  /// The round wall consists of the points for which `across` times the vector from `center` has length
  /// `radius` [µm]: across = (1,1,1) for a sphere, with a 0 for the axis of a cylinder. Radius 0: no round
  /// wall.
  Vec3 center = Vec3::Zero(), across = Vec3::Zero();
  double radius = 0.0;
  /// The lumen lies between these planes [µm]; infinite: no plane.
  Vec3 lo = Vec3::Constant(-std::numeric_limits<double>::infinity());
  Vec3 hi = Vec3::Constant(std::numeric_limits<double>::infinity());

  /// Without the planes perpendicular to these axes.
  ClosedFormWall without(const std::array<bool, 3>& axes) const;
  bool exists() const { return radius > 0.0 || lo.array().isFinite().any() || hi.array().isFinite().any(); }

  /// Distance to the nearest of these walls. Outside an edge between two walls it is smaller than the true
  /// distance.
  WallDistance distance(const Vec3& p) const;
};

/// Result of testing a placed mesh against a wall.
struct WallVerdict {
  /// Empty if the mesh is entirely inside the lumen and does not intersect the wall (exact), otherwise a
  /// description of the violation ("meets the wall", "is outside the lumen", ...).
  std::optional<std::string> violation;
  /// Distance between mesh and wall [µm] if there is no violation and it is below the gap of interest,
  /// otherwise infinity. Exceeds the true distance at most by a rounding error.
  double gap = std::numeric_limits<double>::infinity();
};

/// The wall for one species of cells.
class Wall : public DistanceSource {
 public:
  /// The distance at samplingSpacing(), and at about a micrometre: interpolated, for points in this region.
  /// Made once and kept as long as the wall. Any thread can call.
  const SampledDistance& sampled(const Box& region) const {
    return samples_.of(*this, region, samplingSpacing());
  }
  const SampledDistance& coarselySampled(const Box& region) const;

  /// Distance and gradient at `p` [µm]; defined everywhere, including outside the lumen.
  virtual WallDistance distance(const Vec3& p) const = 0;

  /// The distance without the planes that close the lumen at its ends along these axes: closed ends are not
  /// the wall that blood flows along.
  virtual WallDistance distanceToSides(const Vec3& p, const std::array<bool, 3>& ends) const;

  /// Largest amount by which distance() can exceed the true distance [µm]; 0 for closed forms.
  virtual double slack() const { return 0.0; }

  /// The same wall as a formula, if there is one.
  virtual std::optional<ClosedFormWall> closedForm() const { return {}; }

  /// Of a wall of cubes: a smooth lower bound of the distance, for membranes, which catch on edges. It grows
  /// by at most as much as the distance, up to smoothReach(); where it is 0 the distance is less than
  /// smoothedBelow times that.
  virtual WallDistance smoothed(const Vec3& p) const { return distance(p); }
  virtual double smoothReach() const { return 0.0; }  ///< 0: there is none [µm]
  static constexpr double smoothedBelow = 2.2;

  /// Without a closed form: spacing at which the distance can be sampled and interpolated [µm], on nodes at
  /// integer multiples of it.
  virtual double samplingSpacing() const { return 0.25; }

  /// Distances [µm] at the nodes of a block, x fastest: equal to distance() up to rounding or the
  /// interpolation error at samplingSpacing(). Several spacings inside the lumen they can be smaller, but not
  /// below three fifths. Overridden if there is a cheaper way than node by node.
  void sample(const NodeBlock& block, float* distances) const override;

  /// Cheap test: true if a mesh in this sphere certainly has no violation and is further than `gap` from the
  /// wall [µm].
  virtual bool isAway(const Sphere& sphere, double gap) const {
    return distance(sphere.center).distance - slack() > sphere.radius + gap;
  }

  /// Exact test of a placed mesh. Only gaps below `gapOfInterest` are measured [µm]; 0: none.
  virtual WallVerdict examine(const PlacedHierarchy& cell, double gapOfInterest) const = 0;

  /// Only the violation, of a mesh given by its world vertices.
  std::optional<std::string> violation(const TriangleMesh& placedCell) const {
    return examine({MeshHierarchy(placedCell), Placement()}, 0.0).violation;
  }

 private:
  /// A copy of a wall has none of these, since they refer to the wall.
  class Samples {
   public:
    Samples() = default;
    Samples(const Samples&) {}
    Samples& operator=(const Samples&) { return *this; }
    const SampledDistance& of(const Wall& wall, const Box& region, double spacing) const;

   private:
    struct Made {
      Box region;
      std::unique_ptr<SampledDistance> samples;
    };
    mutable std::mutex mutex_;
    mutable std::vector<Made> made_;
  };
  Samples samples_;
};

/// A lumen: extent, periodicity, volume and wall.
class Container {
 public:
  virtual ~Container() = default;

  /// Bounding box of the lumen [µm]; along a periodic axis it spans exactly one period.
  virtual Box bounds() const = 0;

  /// Period along each axis [µm], 0 where the container is not periodic.
  virtual Vec3 period() const = 0;

  /// The bounds and at least `margin` around them [µm]; for small cells all the same, so that samples of
  /// distances are shared.
  Box surroundings(double margin) const {
    constexpr double step = 16.0;
    return bounds().grownBy(step * std::max(1.0, std::ceil(margin / step)));
  }

  /// Volume of the lumen [µm³], of one period if it is periodic; see makeVessel for a vessel with continued
  /// ends.
  virtual double volume() const = 0;

  /// The wall, or nullptr if there is none (periodic along every axis).
  virtual const Wall* wall() const = 0;

  /// Description in one line: "periodic box 50 x 50 x 50 µm".
  virtual std::string describe() const = 0;

  /// Closed surface of the lumen, for pictures and engines.
  virtual TriangleMesh surface() const = 0;
};

/// Tests a cell in a convex lumen: it is inside if its vertices are, and its gap to the wall is that of the
/// nearest vertex.
/// @param inside true if a point is in the lumen and not on its wall; a computation with rounding errors must
/// return false in case of doubt
template <class Inside>
WallVerdict verdictInConvex(const Wall& wall, const PlacedHierarchy& cell, double gapOfInterest,
                            Inside&& inside) {
  WallVerdict verdict;
  std::size_t within = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < cell.vertexCount(); ++i) {
    const Vec3 v = cell.vertex(i);
    within += inside(v);
    if (within > 0 && within <= i) break;  // it meets the wall
    if (gapOfInterest > 0.0) nearest = std::min(nearest, wall.distance(v).distance);
  }
  if (within < cell.vertexCount())
    verdict.violation = within == 0 ? "is outside the lumen" : "meets the wall";
  else if (nearest < gapOfInterest)
    verdict.gap = nearest;
  return verdict;
}

}  // namespace packmesh
