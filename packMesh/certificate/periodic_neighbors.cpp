// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/periodic_neighbors.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "packMesh/core/error.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/core/vector_text.h"

namespace packmesh {

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
