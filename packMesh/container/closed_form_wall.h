// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Walls described by a formula.
#pragma once

#include <array>
#include <limits>

#include "packMesh/field/distance_source.h"

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

}  // namespace packmesh
