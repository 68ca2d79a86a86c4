// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which cells, or periodic images of cells, come near each other.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "packMesh/mesh/sphere_grid.h"

namespace packmesh {

/// Two cells near each other; `shift` is to be added to the second [µm]. first < second, or first == second
/// and the shift is that of a later image (one of each two that are mirror images of each other).
struct NearPair {
  std::int64_t first, second;
  Vec3 shift;
  double apart;  ///< distance between their spheres [µm]; the same bits whichever of the two was asked for
};

/// Neighbour search among spheres with periodic images.
///
/// Images are not stored: a sphere is looked for at each of its images that comes near the others (as many as
/// it takes, up to a hundred along an axis: a period may be smaller than a sphere), so memory is that of the
/// grid, below 100 bytes per sphere.
class PeriodicNeighbors {
 public:
  /// @param period [µm] along each axis, 0: not periodic; spheres may lie anywhere, also outside the period
  /// @throws InputError for spheres more than 1e9 periods away, or not finite
  PeriodicNeighbors(std::vector<Sphere> spheres, const Vec3& period);

  /// Calls visit(pair) for each pair of `sphere` with another one (or an image of one, or of itself) that
  /// comes nearer than `margin` to it. With `onlyLater` pairs with smaller indices are left out, so that over
  /// all spheres each pair comes up once.
  /// @throws InputError when the sphere has more than a hundred images along an axis to be looked at
  void forEachNear(std::int64_t sphere, double margin, bool onlyLater,
                   const std::function<void(const NearPair&)>& visit) const;

 private:
  /// Spheres moved into one period, and by how many periods each was moved.
  std::vector<Sphere> wrapped_;
  std::vector<std::array<std::int32_t, 3>> moved_;
  Vec3 period_;
  Box bounds_;  ///< of the wrapped spheres, with their radii
  SphereGrid grid_;
};

}  // namespace packmesh
