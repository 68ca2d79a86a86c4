// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Neighbour search among cells and their periodic images.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "packMesh/core/tolerances.h"
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
  /// that is closer than `margin` [µm], if wanted(other), which is asked of some that are further away, too.
  /// @throws InputError if more than a hundred images of the sphere along an axis are relevant
  template <class Wanted, class Visit>
  void forEachNear(std::int64_t sphere, double margin, const Wanted& wanted, const Visit& visit) const {
    // Images j = first .. last, moved by j periods, come near the bounds of the others.
    Periods first, last;
    findImages(sphere, margin, first, last);
    const double touching = margin + tolerance::culling;
    for (std::int32_t z = first[2]; z <= last[2]; ++z)
      for (std::int32_t y = first[1]; y <= last[1]; ++y)
        for (std::int32_t x = first[0]; x <= last[0]; ++x) {
          const Sphere image = {wrapped_[sphere].center + along({x, y, z}), wrapped_[sphere].radius};
          // The grid computes distances from the position of the image, with different rounding than from
          // the other sphere.
          grid_.forEachNear(image, touching, [&](int other) {
            if (!wanted(other)) return;
            NearPair pair;
            if (join(sphere, other, {x, y, z}, pair) && pair.apart < margin) visit(pair);
          });
        }
  }

  /// The same for each pair with a sphere that comes later, or an image of itself, so that a loop over all
  /// spheres visits each pair once.
  template <class Visit>
  void forEachLater(std::int64_t sphere, double margin, const Visit& visit) const {
    forEachNear(
        sphere, margin, [=](std::int64_t other) { return other >= sphere; }, visit);
  }

  /// All spheres, in an order in which successive ones are mostly near each other.
  std::vector<std::int32_t> spatialOrder() const { return grid_.order(); }

 private:
  using Periods = std::array<std::int32_t, 3>;

  void findImages(std::int64_t sphere, double margin, Periods& first, Periods& last) const;
  /// The pair of `sphere`, moved by so many periods, and `other`. @return false: they are the sphere itself,
  /// or the mirror image of a pair visited anyway
  bool join(std::int64_t sphere, std::int64_t other, Periods moved, NearPair& pair) const;
  Vec3 along(const Periods& n) const { return {n[0] * period_[0], n[1] * period_[1], n[2] * period_[2]}; }

  /// Spheres wrapped into one period, and the number of periods each was moved by.
  std::vector<Sphere> wrapped_;
  std::vector<Periods> moved_;
  Vec3 period_;
  Box bounds_;  ///< bounds of the wrapped spheres, radii included
  SphereGrid grid_;
};

}  // namespace packmesh
