// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Neighbour search among spheres of very different sizes.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "packMesh/core/box.h"
#include "packMesh/core/sphere.h"

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

}  // namespace packmesh
