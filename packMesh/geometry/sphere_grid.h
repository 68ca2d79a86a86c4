// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Neighbour search among spheres of very different sizes.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "packMesh/geometry/box.h"

namespace packmesh {

struct Sphere {
  Vec3 center;
  double radius;
};

/// A hierarchy of uniform grids, one for each power of two of the radius, so that a few large spheres among
/// many small ones cost nothing extra. Not periodic: periodic images are spheres of their own (ghosts).
class SphereGrid {
 public:
  explicit SphereGrid(const std::vector<Sphere>& spheres);

  /// Calls `visit(j)` for every sphere j whose surface comes nearer than `margin` to the surface of `query`.
  /// The order depends on the spheres alone.
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
          for (int e = level.start[row + lo[0]]; e < level.start[row + hi[0] + 1]; ++e) {
            const Entry& entry = level.entries[e];
            const double touch = query.radius + margin + entry.sphere.radius;
            if ((entry.sphere.center - query.center).squaredNorm() < touch * touch) visit(entry.index);
          }
        }
    }
  }

 private:
  struct Entry {
    Sphere sphere;
    int index;
  };
  struct Level {
    double largestRadius = 0.0;
    Box bounds;
    double cellsPerLength[3];
    int cells[3];
    std::vector<int> start;  ///< first entry of each cell, x fastest; one past the last at the end
    std::vector<Entry> entries;
  };

  static int cellIndex(const Level& level, int axis, double coordinate) {
    const double cell = std::floor((coordinate - level.bounds.lo[axis]) * level.cellsPerLength[axis]);
    return cell <= 0.0 ? 0 : cell >= level.cells[axis] - 1 ? level.cells[axis] - 1 : static_cast<int>(cell);
  }

  std::vector<Level> levels_;
};

}  // namespace packmesh
