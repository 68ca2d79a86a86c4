// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Periodic images.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "packMesh/core/box.h"

namespace packmesh {

/// Number of periods along each axis; 0 along axes that are not periodic.
using ImageShift = std::array<std::int8_t, 3>;

inline Vec3 displacement(const ImageShift& shift, const Vec3& period) {
  return {shift[0] * period[0], shift[1] * period[1], shift[2] * period[2]};
}

/// `p` shifted by whole periods into [bounds.lo, bounds.hi) along the periodic axes.
inline Vec3 wrapped(Vec3 p, const Box& bounds, const Vec3& period) {
  for (int k = 0; k < 3; ++k)
    if (period[k] > 0.0) {
      p[k] -= period[k] * std::floor((p[k] - bounds.lo[k]) / period[k]);
      if (p[k] >= bounds.hi[k]) p[k] = bounds.lo[k];  // rounding of a tiny negative difference
    }
  return p;
}

/// The difference of two positions by the nearest images [µm].
inline Vec3 nearestImage(Vec3 between, const Vec3& period) {
  for (int k = 0; k < 3; ++k)
    if (period[k] > 0.0) between[k] -= period[k] * std::round(between[k] / period[k]);
  return between;
}

/// Calls `visit(shift)`, in a fixed order, for every shift (zero included) for which the image of a sphere of
/// radius `reach` [µm] around `p` meets the bounds. Pre: `p` is inside the bounds
template <class Visit>
void forEachImage(const Vec3& p, double reach, const Box& bounds, const Vec3& period, Visit&& visit) {
  int lo[3] = {0, 0, 0}, hi[3] = {0, 0, 0};
  for (int k = 0; k < 3; ++k)
    if (period[k] > 0.0) {
      lo[k] = static_cast<int>(std::ceil((bounds.lo[k] - reach - p[k]) / period[k]));
      hi[k] = static_cast<int>(std::floor((bounds.hi[k] + reach - p[k]) / period[k]));
    }
  for (int z = lo[2]; z <= hi[2]; ++z)
    for (int y = lo[1]; y <= hi[1]; ++y)
      for (int x = lo[0]; x <= hi[0]; ++x)
        visit(ImageShift{static_cast<std::int8_t>(x), static_cast<std::int8_t>(y),
                         static_cast<std::int8_t>(z)});
}

/// Translations to the nearest periodic images, in every combination of axes, including zero [µm].
inline std::vector<Vec3> periodicShifts(const Vec3& period) {
  const auto steps = [&](int k) { return period[k] > 0 ? std::vector<int>{-1, 0, 1} : std::vector<int>{0}; };
  std::vector<Vec3> shifts;
  for (const int i : steps(0)) {
    for (const int j : steps(1)) {
      for (const int k : steps(2)) shifts.push_back(period.cwiseProduct(Vec3(i, j, k)));
    }
  }
  return shifts;
}

}  // namespace packmesh
