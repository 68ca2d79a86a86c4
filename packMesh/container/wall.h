// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What bounds a lumen.
#pragma once

#include <limits>
#include <optional>
#include <string>

#include "packMesh/container/closed_form_wall.h"
#include "packMesh/core/sphere.h"
#include "packMesh/field/distance_source.h"
#include "packMesh/mesh/mesh_hierarchy.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// What a wall says of a placed mesh.
struct WallVerdict {
  /// Nothing when the mesh is wholly inside the lumen and meets no wall (exact), otherwise what is wrong with
  /// it
  /// ("meets the wall", "is outside the lumen", ...).
  std::optional<std::string> violation;
  /// Distance between mesh and wall [µm] when there is no violation and it is below the gap of interest, else
  /// infinity. Never more than a rounding error above the true distance.
  double gap = std::numeric_limits<double>::infinity();
};

/// The wall as one species of cells meets it.
class Wall : public DistanceSource {
 public:
  /// Distance and gradient at `p` [µm]; defined everywhere, also outside the lumen.
  virtual WallDistance distance(const Vec3& p) const = 0;

  /// How much distance() may exceed the true distance anywhere [µm]; 0 for closed forms.
  virtual double slack() const { return 0.0; }

  /// The same wall as a formula, if there is one.
  virtual std::optional<ClosedFormWall> closedForm() const { return {}; }

  /// Without a closed form: the spacing at which the distance may be sampled and interpolated [µm], on nodes
  /// at whole multiples of it.
  virtual double samplingSpacing() const { return 0.25; }

  /// Distances [µm] at the nodes of a block, x fastest: what distance() says there, to rounding or to within
  /// what interpolation at the samplingSpacing() errs by; several spacings inside the lumen it may be less,
  /// but not below three fifths of it. Overridden where that is cheaper than node by node.
  void sample(const NodeBlock& block, float* distances) const override;

  /// Whether it is certain, at little cost, that a mesh in this sphere violates nothing and is further than
  /// `gap` from the wall [µm].
  virtual bool isAway(const Sphere& sphere, double gap) const {
    return distance(sphere.center).distance - slack() > sphere.radius + gap;
  }

  /// Exact verdict on a placed mesh. Only gaps below `gapOfInterest` are measured [µm]; 0: none.
  virtual WallVerdict examine(const PlacedHierarchy& cell, double gapOfInterest) const = 0;

  /// The violation alone, of a mesh that is where its vertices are.
  std::optional<std::string> violation(const TriangleMesh& placedCell) const {
    return examine({MeshHierarchy(placedCell), Placement()}, 0.0).violation;
  }
};

}  // namespace packmesh
