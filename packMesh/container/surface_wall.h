// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Exact verdicts of walls that are surfaces, periodic along one axis or not.
#pragma once

#include <functional>

#include "packMesh/container/container.h"

namespace packmesh {

/// The surface of a lumen; may repeat along an axis.
class SurfaceWall {
 public:
  /// @param surface what cells must not meet; open where a periodic lumen goes on
  /// @param lo, period where the first period begins along `axis`, and its length [µm]; 0: not periodic
  SurfaceWall(const TriangleMesh& surface, int axis, double lo, double period);

  /// Exact verdict on a placed mesh.
  /// @param nearest distance to what else is a wall [µm]; counts for the gap where it is below gapOfInterest
  /// @param contains whether a point that is not on the surface is in the lumen
  WallVerdict examine(const PlacedHierarchy& cell, double gapOfInterest, double nearest,
                      const std::function<bool(const Vec3&)>& contains) const;

  bool periodic() const { return period_ > 0.0; }

  /// The image of the lumen that x along the axis lies in; 0 when it is not periodic.
  int imageOf(double x) const;

  /// p in the image with this number.
  Vec3 shifted(Vec3 p, int image) const {
    if (image != 0) p[axis_] += image * period_;
    return p;
  }

 private:
  MeshHierarchy surface_;
  Box box_;
  int axis_;
  double lo_, period_;
};

}  // namespace packmesh
