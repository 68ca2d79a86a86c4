// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/fahraeus.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "packMesh/container/side_wall.h"

namespace packmesh::hemocell {

double tubeHematocrit(double dischargeHematocrit, double diameter) {
  const double h = dischargeHematocrit;
  const double x = 1.0 + 1.7 * std::exp(-0.415 * diameter) - 0.6 * std::exp(-0.011 * diameter);
  return h * (h + (1.0 - h) * std::min(x, 1.0));  // below 2.6 µm the fit would exceed 1
}

double dischargeHematocrit(double tube, double diameter) {
  double low = 0.0, high = 1.0;
  constexpr int bits = 60;
  for (int i = 0; i < bits; ++i) {
    const double middle = 0.5 * (low + high);
    (tubeHematocrit(middle, diameter) < tube ? low : high) = middle;
  }
  return high;
}

double freeLayerOf(double tube, double diameter) {
  constexpr double widest = 75.0;
  const double d = std::min(diameter, widest);
  const double core = 2.0 - dischargeHematocrit(tube, d) / tube;
  return 0.5 * d * (1.0 - std::sqrt(std::clamp(core, 0.0, 1.0)));
}

std::optional<double> hydraulicDiameter(const Container& lumen, const std::array<bool, 3>& ends) {
  if (!lumen.wall()) return {};
  if (const auto form = lumen.wall()->closedForm()) {
    const ClosedFormWall sides = form->without(ends);
    if (!sides.exists()) return {};
    const bool planes = sides.lo.array().isFinite().any() || sides.hi.array().isFinite().any();
    if (sides.radius > 0.0 && sides.across.minCoeff() == 0.0 && !planes) return 2.0 * sides.radius;
  }
  const TriangleMesh surface = lumen.surface();
  const Box bounds = boundingBox(surface);
  const double rounding = 1e-6 * bounds.size().maxCoeff();  // of vertices in the planes of the ends
  double area = 0.0;
  for (const Triangle& t : surface.triangles) {
    const Vec3 &a = surface.vertices[t[0]], &b = surface.vertices[t[1]], &c = surface.vertices[t[2]];
    bool end = false;
    for (int k = 0; k < 3; ++k)
      for (const double plane : {bounds.lo[k], bounds.hi[k]})
        end = end || (ends[k] && std::max({std::abs(a[k] - plane), std::abs(b[k] - plane),
                                           std::abs(c[k] - plane)}) < rounding);
    if (!end) area += 0.5 * (b - a).cross(c - a).norm();
  }
  if (!(area > 0.0)) return {};
  return 4.0 * signedVolume(surface) / area;
}

std::optional<std::string> fahraeusWarning(double diameter) {
  if (diameter >= narrowestFahraeus && diameter <= widestFahraeus) return {};
  return fmt::format(
      "a diameter of {:.4g} µm is outside of the {:g} to {:g} µm to which the Fåhraeus relation is applied",
      diameter, narrowestFahraeus, widestFahraeus);
}

}  // namespace packmesh::hemocell
