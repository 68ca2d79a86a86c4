// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/neighbor_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "packMesh/core/error.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/core/vector.h"
#include "packMesh/simd/lanes.h"

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
    // Cells as wide as the largest sphere, so that a row of three contains about ten touching spheres, but
    // never many more cells than spheres.
    const Vec3 size = level.bounds.size();
    double width = std::max(2.0 * level.largestRadius, 1e-300);
    const auto count = [&](double w) {
      double product = 1.0;
      for (int k = 0; k < 3; ++k) product *= std::floor(size[k] / w) + 1.0;
      return product;
    };
    while (count(width) > static_cast<double>(members.size()) + 64.0) width *= 1.25;
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
    level.spheres.resize(members.size());
    level.indices.resize(members.size());
    std::vector<int> next(level.start.begin(), level.start.end() - 1);
    for (int i : members) {
      const int e = next[cellOf(spheres[i].center)]++;
      level.spheres[e] = spheres[i];
      level.indices[e] = i;
    }
    level.origin = level.bounds.center();
    // Larger than the rounding errors of positions and radii in floats, 6e-8 each.
    level.rounding = static_cast<float>(1e-6 * (size.norm() + level.largestRadius));
    for (std::vector<float>* values : {&level.x, &level.y, &level.z, &level.radius})
      values->resize(members.size() + laneCount);
    for (std::size_t e = 0; e < members.size(); ++e) {
      const Sphere& sphere = level.spheres[e];
      const Vec3 at = sphere.center - level.origin;
      level.x[e] = static_cast<float>(at.x());
      level.y[e] = static_cast<float>(at.y());
      level.z[e] = static_cast<float>(at.z());
      level.radius[e] = static_cast<float>(sphere.radius);
    }
    levels_.push_back(std::move(level));
  }
}

SphereGrid::Nearness SphereGrid::nearness(const Level& level, int begin, int end, const Sphere& query,
                                          double margin) {
  const Vec3 at = query.center - level.origin;
  const Lanes x = splat(static_cast<float>(at.x())), y = splat(static_cast<float>(at.y())),
              z = splat(static_cast<float>(at.z()));
  const auto own = static_cast<float>(query.radius + margin);
  // As for Level::rounding.
  const float rounding = 1e-6f * (std::abs(own) + static_cast<float>(at.norm())) + level.rounding;
  const int count = std::min(end - begin, chunk);
  const std::uint64_t all = count < chunk ? (std::uint64_t{1} << count) - 1u : ~std::uint64_t{0};
  if (!(own + rounding < 1e15f)) return {all, 0};  // larger squares would overflow
  Nearness near;
  for (int k = 0; k < count; k += laneCount) {
    const int e = begin + k;
    const Lanes dx = load(&level.x[e]) - x, dy = load(&level.y[e]) - y, dz = load(&level.z[e]) - z,
                radius = load(&level.radius[e]);
    const Lanes squared = dx * dx + dy * dy + dz * dz, most = radius + (own + rounding),
                least = larger(radius + (own - rounding), splat(0.0f));
    near.possible |= std::uint64_t{bitsWhereLess(squared, most * most)} << k;
    near.certain |= std::uint64_t{bitsWhereLess(squared, least * least)} << k;
  }
  near.possible &= all;
  return near;
}

namespace {

/// Largest number of images along an axis that are searched, and of periods from the origin. A sphere that
/// needs more does not belong to a lumen with this period.
constexpr double mostImages = 100.0, furthest = 1e9;

void requireBelow(double limit, double periods, const Sphere& sphere, double period) {
  if (periods < limit) return;  // false for NaN
  throw InputError(
      fmt::format("the cell at {1}, {0:.4g} µm wide, is too large or too far away for a lumen with a period "
                  "of {2:.4g} µm",
                  2.0 * sphere.radius, toText(sphere.center), period));
}

std::vector<std::array<std::int32_t, 3>> wrap(std::vector<Sphere>& spheres, const Vec3& period) {
  std::vector<std::array<std::int32_t, 3>> moved(spheres.size(), {0, 0, 0});
  for (std::size_t i = 0; i < spheres.size(); ++i)
    for (int k = 0; k < 3; ++k)
      if (period[k] > 0.0) {
        const double periods = std::floor(spheres[i].center[k] / period[k]);
        requireBelow(furthest, std::abs(periods), spheres[i], period[k]);
        moved[i][k] = static_cast<std::int32_t>(periods);
        spheres[i].center[k] -= moved[i][k] * period[k];
      }
  return moved;
}

Box boundsOf(const std::vector<Sphere>& spheres) {
  Box box;
  for (const Sphere& s : spheres) box.add(Box{s.center.array() - s.radius, s.center.array() + s.radius});
  return box;
}

}  // namespace

PeriodicNeighbors::PeriodicNeighbors(std::vector<Sphere> spheres, const Vec3& period)
    : wrapped_(std::move(spheres)),
      moved_(wrap(wrapped_, period)),
      period_(period),
      bounds_(boundsOf(wrapped_)),
      grid_(wrapped_) {}

void PeriodicNeighbors::findImages(std::int64_t sphere, double margin, Periods& first, Periods& last) const {
  const Sphere& own = wrapped_[sphere];
  first = last = {0, 0, 0};
  for (int k = 0; k < 3; ++k)
    if (period_[k] > 0.0) {
      const double reach = own.radius + margin + tolerance::culling;
      const double lowest = std::ceil((bounds_.lo[k] - reach - own.center[k]) / period_[k]);
      const double highest = std::floor((bounds_.hi[k] + reach - own.center[k]) / period_[k]);
      requireBelow(mostImages, highest - lowest, own, period_[k]);
      first[k] = static_cast<std::int32_t>(lowest);
      last[k] = static_cast<std::int32_t>(highest);
    }
}

bool PeriodicNeighbors::join(std::int64_t sphere, std::int64_t other, Periods moved, NearPair& pair) const {
  // The image of `sphere` moved by `moved` meets `other`; equivalently, `other` moved by the opposite meets
  // `sphere`.
  Periods n;
  for (int k = 0; k < 3; ++k) n[k] = moved_[sphere][k] - moved_[other][k] - moved[k];
  pair.first = sphere;
  pair.second = other;
  if (other == sphere) {
    if (n <= Periods{0, 0, 0}) return false;
  } else if (other < sphere) {
    std::swap(pair.first, pair.second);
    for (std::int32_t& k : n) k = -k;
    for (std::int32_t& k : moved) k = -k;
  }
  const Sphere &a = wrapped_[pair.first], &b = wrapped_[pair.second];
  pair.apart = (a.center - b.center + along(moved)).norm() - (a.radius + b.radius);
  pair.shift = along(n);
  return true;
}

}  // namespace packmesh
