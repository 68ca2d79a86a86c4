// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/depth_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "hemocell_adapter/hemocell/voxel_lumen.h"
#include "packMesh/container/side_wall.h"

namespace packmesh::hemocell {
namespace {

/// Edge of the cubes in which a wall of stairs is taken for a plane [lattice spacings].
constexpr double flatPart = 4.0;

/// Area of a surface without its ends [µm²].
/// @param spacing of the stairs that it consists of, if it does: the area is that of the smooth surface,
/// whose parts have the mean normals of the stairs
double areaOfSides(const TriangleMesh& surface, const std::array<bool, 3>& ends,
                   std::optional<double> spacing) {
  const Box bounds = boundingBox(surface);
  const double rounding = 1e-6 * bounds.size().maxCoeff();  // of vertices in the planes of the ends
  double area = 0.0;
  std::map<std::array<int, 3>, Vec3> parts;  // of stairs: area and mean normal
  for (const Triangle& t : surface.triangles) {
    const Vec3 &a = surface.vertices[t[0]], &b = surface.vertices[t[1]], &c = surface.vertices[t[2]];
    bool end = false;
    for (int k = 0; k < 3; ++k)
      for (const double plane : {bounds.lo[k], bounds.hi[k]})
        end = end || (ends[k] && std::max({std::abs(a[k] - plane), std::abs(b[k] - plane),
                                           std::abs(c[k] - plane)}) < rounding);
    if (end) continue;
    const Vec3 facing = 0.5 * (b - a).cross(c - a);
    if (!spacing) {
      area += facing.norm();
      continue;
    }
    std::array<int, 3> part;
    for (int k = 0; k < 3; ++k)
      part[k] = static_cast<int>(std::floor((a[k] + b[k] + c[k]) / (3.0 * flatPart * *spacing)));
    parts.try_emplace(part, Vec3::Zero()).first->second += facing;
  }
  for (const auto& [part, facing] : parts) area += facing.norm();
  return area;
}

}  // namespace

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
  const std::optional<double> spacing = voxelSpacing(lumen);
  const TriangleMesh surface = lumen.surface();
  const double area = areaOfSides(surface, ends, spacing);
  if (!(area > 0.0)) return {};
  return 4.0 * (spacing ? lumen.volume() : signedVolume(surface)) / area;
}

std::optional<std::string> fahraeusWarning(double diameter) {
  if (diameter >= narrowestFahraeus && diameter <= widestFahraeus) return {};
  return fmt::format(
      "a diameter of {:.4g} µm is outside of the {:g} to {:g} µm to which the Fåhraeus relation is applied",
      diameter, narrowestFahraeus, widestFahraeus);
}

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
