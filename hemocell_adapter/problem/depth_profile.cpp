// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/depth_profile.h"

#include <algorithm>
#include <cmath>

namespace packmesh::hemocell {

int DepthProfile::layerAt(double depthOfPoint) const {
  return std::clamp(static_cast<int>(std::floor(depthOfPoint / width)), 0,
                    static_cast<int>(lumen.size()) - 1);
}

int DepthProfile::shellAt(double depthOfPoint) const {
  const auto above = std::upper_bound(edges.begin() + 1, edges.end() - 1, depthOfPoint);
  return static_cast<int>(above - edges.begin()) - 1;
}

double DepthProfile::askedIn(int shell) const {
  double fraction = 0.0;
  for (const SpeciesProfile& one : species)
    if (one.isAsked()) fraction += askedIn(one, shell);
  return fraction;
}

double DepthProfile::askedIn(const SpeciesProfile& one, int shell) const {
  double volume = 0.0, cells = 0.0;
  for (std::size_t k = 0; k < lumen.size(); ++k) {
    if (shellAt((double(k) + 0.5) * width) != shell) continue;
    volume += lumen[k];
    cells += lumen[k] * one.asked[k];
  }
  return volume > 0.0 ? cells / volume : 0.0;
}

}  // namespace packmesh::hemocell
