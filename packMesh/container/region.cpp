// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/region.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "packMesh/parallel/blocks.h"

namespace packmesh {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();

/// Maximum number of times cubes are halved; fewer if distances take long to compute.
constexpr int deepestInClosedForm = 8, deepestElsewhere = 7;

WallDistance inLumen(const Container& lumen, const Vec3& p) {
  const Wall* wall = lumen.wall();
  return wall ? wall->distance(p) : WallDistance{endless, Vec3::UnitX()};
}

const WallDistance& nearer(const WallDistance& a, const WallDistance& b) {
  return b.distance < a.distance ? b : a;
}

/// Volume of the part of the region in a box that can be halved `depth` times.
double volumeIn(const Region& region, const Container& lumen, const Box& box, int depth) {
  const double reach = 0.5 * box.size().norm() + (lumen.wall() ? lumen.wall()->slack() : 0.0);
  const WallDistance toWall = inLumen(lumen, box.center()), toSurface = region.distance(box.center());
  return volumeByHalving(box, nearer(toWall, toSurface), reach, depth, [&](const Box& part, int further) {
    return volumeIn(region, lumen, part, further);
  });
}

}  // namespace

BodyRegion::BodyRegion(std::shared_ptr<const Container> body, const Box& bounds, const Vec3& period)
    : body_(std::move(body)), shifts_(periodicShifts(period)), bounds_(bounds) {
  Box own;
  for (const Vec3& shift : shifts_) {
    const Box image{body_->bounds().lo + shift, body_->bounds().hi + shift};
    const Box common{image.lo.cwiseMax(bounds.lo), image.hi.cwiseMin(bounds.hi)};
    if ((common.size().array() > 0.0).all()) own.add(common.lo), own.add(common.hi);
  }
  if ((own.size().array() > 0.0).all()) bounds_ = own;
}

/// Distance to the nearest image.
WallDistance BodyRegion::distance(const Vec3& p) const {
  WallDistance best{-endless, Vec3::UnitX()};
  for (const Vec3& shift : shifts_) {
    const WallDistance d = inLumen(*body_, p - shift);
    if (d.distance > best.distance) best = d;
  }
  return best;
}

HalfSpace::HalfSpace(const Vec3& point, const Vec3& normal, const Box& bounds, const Vec3& period)
    : point_(point), normal_(normal), shifts_(periodicShifts(period)), lumen_(bounds) {
  for (int k = 0; k < 3; ++k)
    if (period[k] > 0.0 && normal[k] != 0.0) ends_.push_back(k);
  // Its part of the bounds is spanned by their corners in it, and by where the plane cuts their edges.
  const auto corner = [&](int c) {
    return Vec3(c & 1 ? bounds.hi.x() : bounds.lo.x(), c & 2 ? bounds.hi.y() : bounds.lo.y(),
                c & 4 ? bounds.hi.z() : bounds.lo.z());
  };
  const auto depth = [&](int c) { return (corner(c) - point).dot(normal); };
  for (int c = 0; c < 8; ++c) {
    if (depth(c) >= 0.0) bounds_.add(corner(c));
    for (const int along : {1, 2, 4})
      if ((c & along) == 0 && depth(c) * depth(c | along) < 0.0)
        bounds_.add(corner(c) + depth(c) / (depth(c) - depth(c | along)) * (corner(c | along) - corner(c)));
  }
  if (bounds_.empty()) bounds_ = bounds;  // nothing of the lumen is in it
}

WallDistance HalfSpace::distance(const Vec3& p) const {
  WallDistance best{-endless, normal_};
  for (const Vec3& shift : shifts_) {
    const Vec3 q = p - shift;
    WallDistance d{(q - point_).dot(normal_), normal_};
    for (const int k : ends_) {
      d = nearer(d, {q[k] - lumen_.lo[k], Vec3::Unit(k)});
      d = nearer(d, {lumen_.hi[k] - q[k], -Vec3::Unit(k)});
    }
    if (d.distance > best.distance) best = d;
  }
  return best;
}

WallDistance RegionDifference::distance(const Vec3& p) const {
  WallDistance nearest{endless, Vec3::UnitX()};
  if (inside_) nearest = inside_->distance(p);
  for (const auto& region : outside_) {
    const WallDistance d = region->distance(p);
    nearest = nearer(nearest, {-d.distance, -d.gradient});
  }
  return nearest;
}

double volumeInLumen(const Region& region, const Container& lumen) {
  const bool closedForm = !lumen.wall() || lumen.wall()->closedForm();
  return volumeIn(region, lumen, lumen.bounds(), closedForm ? deepestInClosedForm : deepestElsewhere);
}

}  // namespace packmesh
