// SPDX-License-Identifier: AGPL-3.0-or-later
#include <algorithm>

#include "packMesh/core/tolerances.h"
#include "packMesh/relaxation/contact_solver.h"

namespace packmesh {
namespace {

/// A pair has one contact for either direction, each of which removes omega times the penetration; a wall
/// contact has only one, so that it removes this many times as much.
constexpr double wallPush = 1.9;

Vec3 vectorOf(const float (&v)[3]) {
  return {v[0], v[1], v[2]};
}

double deepestOf(const WallSums& sums) {
  float depth = 0.0f;
  for (int k = 0; k < sums.contacts; ++k) depth = std::max(depth, sums.contact[k].deepest);
  return depth;
}

}  // namespace

void ContactSolver::resolveSurroundings(Body& body, SweepSums& sums) const {
  const Freedom& freedom = species_[body.species].freedom;
  if (freedom.fixed || (body.sleeping && body.moved == 0.0)) return;
  resolveWall(body, sums);
  if (freedom.freeLayer) resolveLayer(body, sums);
  if (freedom.region) resolveRegion(body, sums);
}

void ContactSolver::resolveRegion(Body& body, SweepSums& sums) const {
  const WallDistance toSurface = species_[body.species].freedom.region->distance(body.position);
  const double depth = tolerance::relaxationMargin - slack_ - toSurface.distance;
  if (!(depth > 0.0)) return;
  sums.add(depth);
  body.overlap += depth;
  move(body, omega_ * depth * toSurface.gradient.normalized(), Vec3::Zero());
}

void ContactSolver::resolveWall(Body& body, SweepSums& sums) const {
  const SpeciesModel& species = species_[body.species];
  if (species.wallField == nullptr || body.moved < body.awayFromWallUntil) return;
  const ShapeModel& model = shapes_[body.shape];
  const WallField& wall = *species.wallField;
  const double clearance =
      wallClearance_ + species.freedom.extraWallClearance + body.extraWallClearance - slack_;
  const double reach = model.radius * body.scale;
  const double atCenter = wall.distance(body.position) - wall.slack();
  if (atCenter > reach + clearance) {
    body.awayFromWallUntil = body.moved + atCenter - reach - clearance;
    return;
  }

  const ContactViews& views = model.views();
  const auto lookAt = [&](const SampleView& samples, bool deep, double margin, ClusterMask& mask) {
    WallSums found;
    wallKernel_(samples, wall.frameOf(body, reach, deep), static_cast<float>(clearance),
                static_cast<float>(margin), mask, found);
    body.deepInWall = deepestOf(found) > deepContact;
    return found;
  };
  WallSums found;
  if (body.deepInWall || coarsely_) {
    ClusterMask all = allClusters;
    found = lookAt(views.coarseSamples, true, 0.0, all);
  }
  if (!body.deepInWall && !coarsely_) {
    if (body.moved < body.wallMaskUntil) {
      ClusterMask mask = body.wallMask;  // with margin 0, a full mask would be reduced
      found = lookAt(views.samples, false, 0.0, mask);
      found.nearest =
          std::min(found.nearest, static_cast<float>(clearance + body.wallMaskUntil - body.moved));
    } else {
      const double expected = 0.5 * expectedMotion_;
      body.wallMask = allClusters;
      body.wallMaskUntil = body.moved + expected;
      found = lookAt(views.samples, false, expected, body.wallMask);
    }
  }
  if (found.contacts == 0) {
    if (coarsely_) return;  // coarse samples give no bound of the gap
    body.awayFromWallUntil = body.moved + found.nearest - clearance;
    return;
  }

  push(body, found, sums);
}

void ContactSolver::resolveLayer(Body& body, SweepSums& sums) const {
  const SpeciesModel& species = species_[body.species];
  const ShapeModel& model = shapes_[body.shape];
  const WallField& wall = *species.layerWall;
  const double thickness = species.freedom.freeLayer->thickness + tolerance::relaxationMargin - slack_;
  const double reach = model.radius * body.scale;
  const double atCenter = wall.distance(body.position) - wall.slack();
  if (atCenter > reach + thickness) return;
  const bool deep = coarsely_ || atCenter < thickness - reach;
  ClusterMask all = allClusters;
  WallSums found;
  const ContactViews& views = model.views();
  wallKernel_(deep ? views.coarseSamples : views.samples, wall.frameOf(body, reach, deep),
              static_cast<float>(thickness), 0.0f, all, found);
  push(body, found, sums);
}

void ContactSolver::push(Body& body, const WallSums& found, SweepSums& sums) const {
  const ShapeModel& model = shapes_[body.shape];
  const double inertia = rotate_ ? model.inverseInertia : 0.0;
  for (int k = 0; k < found.contacts; ++k) {
    const WallContact& c = found.contact[k];
    sums.add(c.deepest);
    body.overlap += c.deepest;
    const Vec3 direction = vectorOf(c.normal);
    const double length = direction.norm();
    if (!(length > 0.0)) continue;
    const Vec3 normal = direction / length;
    const Vec3 turn = (vectorOf(c.point) / c.weight).cross(normal);
    const double impulse = wallPush * omega_ * c.deepest / (model.inverseMass + inertia * turn.squaredNorm());
    move(body, impulse * model.inverseMass * normal, impulse * inertia * turn);
  }
}

}  // namespace packmesh
