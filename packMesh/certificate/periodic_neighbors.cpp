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

using Periods = std::array<std::int32_t, 3>;

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

std::vector<Periods> wrap(std::vector<Sphere>& spheres, const Vec3& period) {
  std::vector<Periods> moved(spheres.size(), Periods{0, 0, 0});
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

void PeriodicNeighbors::forEachNear(std::int64_t sphere, double margin, bool onlyLater,
                                    const std::function<void(const NearPair&)>& visit) const {
  const Sphere& own = wrapped_[sphere];
  const auto along = [&](const Periods& n) {
    return Vec3(n[0] * period_[0], n[1] * period_[1], n[2] * period_[2]);
  };
  // Images j = 0 .. n, moved by lo + j periods, come near the bounds of the others.
  Periods lo{0, 0, 0}, hi{0, 0, 0};
  for (int k = 0; k < 3; ++k)
    if (period_[k] > 0.0) {
      const double reach = own.radius + margin + tolerance::culling;
      const double first = std::ceil((bounds_.lo[k] - reach - own.center[k]) / period_[k]);
      const double last = std::floor((bounds_.hi[k] + reach - own.center[k]) / period_[k]);
      requireBelow(mostImages, last - first, own, period_[k]);
      lo[k] = static_cast<std::int32_t>(first);
      hi[k] = static_cast<std::int32_t>(last);
    }
  for (int z = lo[2]; z <= hi[2]; ++z)
    for (int y = lo[1]; y <= hi[1]; ++y)
      for (int x = lo[0]; x <= hi[0]; ++x) {
        const Vec3 image = own.center + along({x, y, z});
        // The grid computes distances from the position of the image, with different rounding than from the
        // other sphere.
        grid_.forEachNear({image, own.radius}, margin + tolerance::culling, [&](int other) {
          // The image of `sphere` moved by (x, y, z) meets `other`; equivalently, `other` moved by (-x, -y,
          // -z) meets `sphere`.
          Periods n{-x, -y, -z};
          for (int k = 0; k < 3; ++k) n[k] += moved_[sphere][k] - moved_[other][k];
          Periods inGrid{x, y, z};
          NearPair pair{sphere, other, {}, 0.0};
          if (other == sphere) {
            if (n <= Periods{0, 0, 0})
              return;  // the sphere itself, or the mirror image of a pair visited anyway
          } else if (other < sphere) {
            if (onlyLater) return;
            std::swap(pair.first, pair.second);
            for (std::int32_t& k : n) k = -k;
            for (std::int32_t& k : inGrid) k = -k;
          }
          const Sphere &a = wrapped_[pair.first], &b = wrapped_[pair.second];
          pair.apart = (a.center - b.center + along(inGrid)).norm() - (a.radius + b.radius);
          if (!(pair.apart < margin)) return;
          pair.shift = along(n);
          visit(pair);
        });
      }
}

}  // namespace packmesh
