// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/body_region.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "packMesh/container/box_share.h"
#include "packMesh/parallel/periodic_images.h"

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

BodyRegion::BodyRegion(std::shared_ptr<const Container> inside,
                       std::vector<std::shared_ptr<const Container>> outside, const Box& bounds,
                       const Vec3& period)
    : inside_(std::move(inside)),
      outside_(std::move(outside)),
      shifts_(periodicShifts(period)),
      bounds_(bounds) {
  if (!inside_) return;
  Box own;
  for (const Vec3& shift : shifts_) {
    const Box body{inside_->bounds().lo + shift, inside_->bounds().hi + shift};
    const Box common{body.lo.cwiseMax(bounds.lo), body.hi.cwiseMin(bounds.hi)};
    if ((common.size().array() > 0.0).all()) own.add(common.lo), own.add(common.hi);
  }
  if ((own.size().array() > 0.0).all()) bounds_ = own;
}

/// Distance to the nearest image of a body, positive inside.
WallDistance BodyRegion::ofBody(const Container& body, const Vec3& p) const {
  WallDistance best{-endless, Vec3::UnitX()};
  for (const Vec3& shift : shifts_) {
    const WallDistance d = inLumen(body, p - shift);
    if (d.distance > best.distance) best = d;
  }
  return best;
}

WallDistance BodyRegion::distance(const Vec3& p) const {
  WallDistance nearest{endless, Vec3::UnitX()};
  if (inside_) nearest = ofBody(*inside_, p);
  for (const auto& body : outside_) {
    const WallDistance d = ofBody(*body, p);
    nearest = nearer(nearest, {-d.distance, -d.gradient});
  }
  return nearest;
}

double volumeInLumen(const Region& region, const Container& lumen) {
  const bool closedForm = !lumen.wall() || lumen.wall()->closedForm();
  return volumeIn(region, lumen, lumen.bounds(), closedForm ? deepestInClosedForm : deepestElsewhere);
}

}  // namespace packmesh
