// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Interface of walls.
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "packMesh/container/closed_form_wall.h"
#include "packMesh/core/sphere.h"
#include "packMesh/field/distance_source.h"
#include "packMesh/field/sampled_distance.h"
#include "packMesh/mesh/mesh_hierarchy.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

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

}  // namespace packmesh
