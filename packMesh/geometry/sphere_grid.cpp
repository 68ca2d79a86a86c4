// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/geometry/sphere_grid.h"

#include <algorithm>
#include <map>

namespace packmesh {

SphereGrid::SphereGrid(const std::vector<Sphere>& spheres) {
  std::map<int, std::vector<int>> byLevel;
  for (int i = 0; i < static_cast<int>(spheres.size()); ++i)
    byLevel[spheres[i].radius > 0.0 ? std::ilogb(spheres[i].radius) : -1000].push_back(i);

  for (const auto& [exponent, members] : byLevel) {
    Level level;
    for (int i : members) {
      level.bounds.add(spheres[i].center);
      level.largestRadius = std::max(level.largestRadius, spheres[i].radius);
    }
    // Cells half as wide as the largest sphere, but never many more cells than spheres.
    const Vec3 size = level.bounds.size();
    double width = std::max(level.largestRadius, 1e-300);
    const auto count = [&](double w) {
      double product = 1.0;
      for (int k = 0; k < 3; ++k) product *= std::floor(size[k] / w) + 1.0;
      return product;
    };
    while (count(width) > 4.0 * members.size() + 64.0) width *= 1.25;
    for (int k = 0; k < 3; ++k) {
      level.cells[k] = static_cast<int>(std::floor(size[k] / width)) + 1;
      level.cellsPerLength[k] = 1.0 / width;
    }

    const auto cellOf = [&](const Vec3& p) {
      return (std::int64_t(cellIndex(level, 2, p[2])) * level.cells[1] + cellIndex(level, 1, p[1])) *
                 level.cells[0] +
             cellIndex(level, 0, p[0]);
    };
    level.start.assign(std::int64_t(level.cells[0]) * level.cells[1] * level.cells[2] + 1, 0);
    for (int i : members) ++level.start[cellOf(spheres[i].center) + 1];
    for (std::size_t c = 1; c < level.start.size(); ++c) level.start[c] += level.start[c - 1];
    level.entries.resize(members.size());
    std::vector<int> next(level.start.begin(), level.start.end() - 1);
    for (int i : members) level.entries[next[cellOf(spheres[i].center)]++] = {spheres[i], i};
    levels_.push_back(std::move(level));
  }
}

}  // namespace packmesh
