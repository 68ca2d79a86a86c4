// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Exact tests against walls that are surfaces, optionally periodic along one axis.
#pragma once

#include <functional>

#include "packMesh/container/container.h"

namespace packmesh {

/// The surface of a lumen, optionally periodic along one axis.
class SurfaceWall {
 public:
  /// @param surface the surface that cells must not meet; open at the ends of a periodic lumen
  /// @param lo, period start of the first period along `axis` and its length [µm]; 0: not periodic
  SurfaceWall(const TriangleMesh& surface, int axis, double lo, double period);

  /// Exact test of a placed mesh.
  /// @param nearest distance to other walls [µm]; included in the gap if below gapOfInterest
  /// @param contains true if a point that is not on the surface is in the lumen
  WallVerdict examine(const PlacedHierarchy& cell, double gapOfInterest, double nearest,
                      const std::function<bool(const Vec3&)>& contains) const;

  bool periodic() const { return period_ > 0.0; }

  /// The image of the lumen that contains x; 0 if it is not periodic.
  int imageOf(double x) const;

  /// p in image `image`.
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
