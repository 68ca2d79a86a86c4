// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Neighbour search among spheres of very different sizes, and among cells and their periodic images.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/core/tolerances.h"

namespace packmesh {

/// A hierarchy of uniform grids, one per power of two of the radius, so that a few large spheres among many
/// small ones cost little. Not periodic: periodic images are separate spheres (ghosts).
class SphereGrid {
 public:
  explicit SphereGrid(const std::vector<Sphere>& spheres);

  /// Calls `visit(j)` for every sphere j whose surface is closer than `margin` [µm] to the surface of
  /// `query`. The order depends only on the spheres.
  template <class Visit>
  void forEachNear(const Sphere& query, double margin, Visit&& visit) const {
    for (const Level& level : levels_) {
      const double reach = query.radius + margin + level.largestRadius;
      int lo[3], hi[3];
      bool outside = false;
      for (int k = 0; k < 3; ++k) {
        lo[k] = cellIndex(level, k, query.center[k] - reach);
        hi[k] = cellIndex(level, k, query.center[k] + reach);
        outside |=
            query.center[k] - reach > level.bounds.hi[k] || query.center[k] + reach < level.bounds.lo[k];
      }
      if (outside) continue;
      for (int z = lo[2]; z <= hi[2]; ++z)
        for (int y = lo[1]; y <= hi[1]; ++y) {
          const std::int64_t row = (std::int64_t(z) * level.cells[1] + y) * level.cells[0];
          const int end = level.start[row + hi[0] + 1];
          for (int begin = level.start[row + lo[0]]; begin < end; begin += chunk) {
            const Nearness found = nearness(level, begin, end, query, margin);
            for (std::uint64_t near = found.possible; near != 0; near &= near - 1) {
              const int bit = __builtin_ctzll(near);
              if ((found.certain >> bit & 1u) || isNear(level.spheres[begin + bit], query, margin))
                visit(level.indices[begin + bit]);
            }
          }
        }
    }
  }

  /// The indices of all spheres, level by level in the order of the grid's cells.
  std::vector<std::int32_t> order() const {
    std::vector<std::int32_t> order;
    for (const Level& level : levels_) order.insert(order.end(), level.indices.begin(), level.indices.end());
    return order;
  }

 private:
  struct Level {
    double largestRadius = 0.0;
    Box bounds;
    double cellsPerLength[3];
    int cells[3];
    std::vector<int> start;       ///< first entry of each cell, x fastest; finally the number of entries
    std::vector<Sphere> spheres;  ///< entries: spheres, cell by cell, and their indices
    std::vector<int> indices;
    /// Copies of the spheres with centres relative to `origin`, padded at the end.
    std::vector<float> x, y, z, radius;
    Vec3 origin;
    float rounding;  ///< upper bound of the error of distances between these [µm]
  };

  /// Number of entries tested together.
  static constexpr int chunk = 64;

  /// Bit k stands for entry begin + k.
  struct Nearness {
    std::uint64_t possible = 0;  ///< includes all that isNear() accepts
    std::uint64_t certain = 0;   ///< only those
  };
  /// Entries from `begin` up to `end`, at most a chunk.
  static Nearness nearness(const Level& level, int begin, int end, const Sphere& query, double margin);

  static bool isNear(const Sphere& sphere, const Sphere& query, double margin) {
    const double touch = query.radius + margin + sphere.radius;
    return (sphere.center - query.center).squaredNorm() < touch * touch;
  }

  static int cellIndex(const Level& level, int axis, double coordinate) {
    const double cell = std::floor((coordinate - level.bounds.lo[axis]) * level.cellsPerLength[axis]);
    return cell <= 0.0 ? 0 : cell >= level.cells[axis] - 1 ? level.cells[axis] - 1 : static_cast<int>(cell);
  }

  std::vector<Level> levels_;
};

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
