// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/unseen_walls.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "packMesh/placement/placement.h"

namespace packmesh::hemocell {
namespace {

/// Points of the surface from which the thickness of the wall is measured: a wall with a hundredth of the
/// area has eighty of them.
constexpr std::int64_t points = 8000;

/// A wall is one where it is thin as far as this around a point: the edge between two branches is not
/// [lattice spacings].
constexpr double around = 3.0;

/// Whether all nodes around a point are fluid.
bool isAmongFluid(const Lattice& lattice, const Vec3& p) {
  const std::array<int, 3> nodes = lattice.nodes();
  std::array<int, 3> low;
  for (int k = 0; k < 3; ++k) {
    low[k] = int(std::floor(p[k] / lattice.dx()));
    if (low[k] < 0 || low[k] + 1 >= nodes[k]) return false;
  }
  for (int n = 0; n < 8; ++n)
    if (!lattice.fluid(low[0] + (n & 1), low[1] + (n >> 1 & 1), low[2] + (n >> 2))) return false;
  return true;
}

/// A thin wall, or one point of it.
struct ThinPlace {
  Vec3 middle;
  double thickness;  ///< [µm]
};

/// The wall behind a point of the surface, if it is thinner than the lattice spacing and has no solid node.
std::optional<ThinPlace> wallBehind(const Wall& wall, const Lattice& lattice, const Vec3& p) {
  const double dx = lattice.dx();
  const Vec3 into = -wall.distance(p).gradient.normalized();
  if (!into.allFinite()) return {};
  const double beyond = wall.distance(p + dx * into).distance;
  if (!(beyond > 0.0)) return {};
  const ThinPlace place{p + 0.5 * (dx - beyond) * into, dx - beyond};
  if (!(place.thickness > 0.0) || !isAmongFluid(lattice, place.middle)) return {};
  if (!(wall.distance(place.middle).distance < 0.0)) return {};  // a grazing ray at a convex wall
  const Vec3 sideways = into.unitOrthogonal(), other = into.cross(sideways);
  for (const Vec3& step : {sideways, Vec3(-sideways), other, Vec3(-other)}) {
    const Vec3 beside = place.middle + around * dx * step;
    if (std::abs(wall.distance(beside).distance) > 0.5 * dx || !isAmongFluid(lattice, beside)) return {};
  }
  return place;
}

}  // namespace

std::optional<std::string> unseenWallWarning(const Lumen& lumen) {
  const Wall* const wall = lumen.container->wall();
  if (!lumen.lattice || !wall || wall->closedForm()) return {};
  if (lumen.container->volume() == lumen.lattice->fluidVolume()) return {};  // it consists of the nodes
  const TriangleMesh surface = lumen.container->surface();
  std::vector<double> areas;  // sums
  double sum = 0.0;
  for (int t = 0; t < int(surface.triangles.size()); ++t) {
    const Vec3 a = surface.corner(t, 0);
    areas.push_back(sum += (surface.corner(t, 1) - a).cross(surface.corner(t, 2) - a).norm());
  }
  std::optional<ThinPlace> thinnest;
  for (std::int64_t i = 0; i < points && sum > 0.0; ++i) {
    const Vec3 u = evenPoint({0.0, 0.0, 0.0, 0.0}, std::uint64_t(i));
    const auto t =
        std::min<std::ptrdiff_t>(std::upper_bound(areas.begin(), areas.end(), u.x() * sum) - areas.begin(),
                                 std::ptrdiff_t(areas.size()) - 1);
    const double root = std::sqrt(u.y());
    const Vec3 p = (1.0 - root) * surface.corner(int(t), 0) +
                   root * (1.0 - u.z()) * surface.corner(int(t), 1) +
                   root * u.z() * surface.corner(int(t), 2);
    const auto place = wallBehind(*wall, *lumen.lattice, p);
    if (place && (!thinnest || place->thickness < thinnest->thickness)) thinnest = place;
  }
  if (!thinnest) return {};
  const Vec3& at = thinnest->middle;
  return fmt::format(
      "a wall is {:.2g} µm thick at ({:.4g}, {:.4g}, {:.4g}), and no node of the lattice is in it (dx {:.6g} "
      "µm): HemoCell does not see it, so that cells on both sides meet through it. Make it thicker, or dx "
      "smaller",
      thinnest->thickness, at.x(), at.y(), at.z(), lumen.lattice->dx());
}

}  // namespace packmesh::hemocell
