// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Neighbour search among cells and their periodic images.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "packMesh/mesh/sphere_grid.h"

namespace packmesh {

/// Two neighbouring cells; `shift` [µm] is to be added to the second. first < second, or first == second and
/// the shift is the later of the two that are mirror images of each other.
struct NearPair {
  std::int64_t first, second;
  Vec3 shift;
  double apart;  ///< distance between the spheres [µm]; the same bits whichever cell is searched from
};

/// Neighbour search among spheres with periodic images.
///
/// Images are not stored: the search is repeated at each relevant image of a sphere (at most a hundred along
/// an axis, since a period can be smaller than a sphere), so memory is that of the grid, below 100 bytes per
/// sphere.
class PeriodicNeighbors {
 public:
  /// @param period [µm] along each axis, 0: not periodic; spheres may lie outside the period
  /// @throws InputError if a sphere is more than 1e9 periods from the origin or not finite
  PeriodicNeighbors(std::vector<Sphere> spheres, const Vec3& period);

  /// Calls visit(pair) for each pair of `sphere` with another sphere, an image of one, or an image of itself
  /// that is closer than `margin` [µm]. With `onlyLater`, pairs with smaller indices are omitted, so that a
  /// loop over all spheres visits each pair once.
  /// @throws InputError if more than a hundred images of the sphere along an axis are relevant
  void forEachNear(std::int64_t sphere, double margin, bool onlyLater,
                   const std::function<void(const NearPair&)>& visit) const;

  /// All spheres, in an order in which successive ones are mostly near each other.
  std::vector<std::int32_t> spatialOrder() const { return grid_.order(); }

 private:
  /// Spheres wrapped into one period, and the number of periods each was moved by.
  std::vector<Sphere> wrapped_;
  std::vector<std::array<std::int32_t, 3>> moved_;
  Vec3 period_;
  Box bounds_;  ///< bounds of the wrapped spheres, radii included
  SphereGrid grid_;
};

}  // namespace packmesh
