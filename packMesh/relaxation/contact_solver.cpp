// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/contact_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "packMesh/core/tolerances.h"

namespace packmesh {
namespace {

/// Inverse inertia of a cell of mass 1 and bounding radius R is this divided by R²: 0.2/µm² for the red cell,
/// the best of values between 0.15 and 0.3; a solid sphere has 2.5.
constexpr double inertiaFactor = 3.0;

/// Masses are proportional to volumes only within these bounds, so that platelets can still push a white
/// cell.
constexpr double largestMassRatio = 10.0;

/// Limits of the rotation and translation of a cell in one step [rad; fraction of its radius].
constexpr double largestTurn = 0.4, largestStep = 0.5;

/// Where the sum of the normals of a deep contact cancels to less than this, crossed discs would lock: the
/// direction between the centres is mixed in. A contact is deep beyond this depth [µm]; for thin cells, this
/// fraction of half their thickness; for pairs that failed the exact test, always.
constexpr double lockedNormal = 0.8, lockedDepth = 0.1, lockedFraction = 0.3;

/// Number of successive tests of a touching pair that only examine the clusters that touched last, and in
/// economical sweeps.
constexpr int mostQuickLooks = 1, mostQuickLooksOfMany = 3;

/// Contacts shallower than this are not resolved [µm]: cells that have been pushed apart then come to rest
/// instead of touching again because of rounding.
constexpr double negligible = 0.1 * tolerance::relaxationTolerance;

}  // namespace

ShapeModel::ShapeModel(const Shape& of, double referenceVolume)
    : shape(&of),
      bound(of.bound()),
      radius(of.radius()),
      inverseMass(std::clamp(referenceVolume / of.volume(), 1.0 / largestMassRatio, largestMassRatio)),
      inverseInertia(inverseMass * inertiaFactor / (radius * radius)),
      lockedDepth(std::min(packmesh::lockedDepth, lockedFraction * of.halfThickness())) {}

/// How a body moves.
struct ContactSolver::Motion {
  Vec3 step;  ///< of its centre [µm]
  Vec3 turn;  ///< rotation vector [rad]

  Motion operator+(const Motion& other) const { return {step + other.step, turn + other.turn}; }
};

/// What one contact does to the body that it pushes along its normal, and to the other one.
struct ContactSolver::Push {
  Motion away, back;
};

/// One contact: the sampled body is pushed along `normal`, the other one in the opposite direction.
struct ContactSolver::Contact {
  Vec3 arm;      ///< from the centre of the pushed body to the point [µm]
  Vec3 backArm;  ///< from the centre of the other body [µm]
  Vec3 normal;   ///< unit
  double depth;  ///< penetration into the clearance [µm]
};

ContactSolver::ContactSolver(std::vector<ShapeModel> shapes, std::vector<SpeciesModel> species,
                             const Box& region, const Vec3& period, double clearance, double wallClearance)
    : shapes_(std::move(shapes)),
      species_(std::move(species)),
      period_(period),
      clearance_(clearance),
      wallClearance_(wallClearance),
      kernel_(contactKernel(chosenInstructionSet())),
      wallKernel_(wallKernel(chosenInstructionSet())) {
  std::map<const Wall*, const WallField*> fields;
  const auto fieldOf = [&](const Wall* wall) {
    const WallField*& field = fields[wall];
    if (field == nullptr && wall != nullptr) {
      walls_.push_back(std::make_unique<WallField>(*wall, region));
      field = walls_.back().get();
    }
    return field;
  };
  for (SpeciesModel& model : species_) {
    model.wallField = fieldOf(model.wall);
    if (const auto& layer = model.freedom.freeLayer) model.layerWall = fieldOf(layer->wall.get());
  }
}

/// Relative pose of two bodies, used for the tests from either side.
struct ContactSolver::Meeting {
  const Body &a, &b;
  Vec3 fromB;  ///< from the centre of b to that of a [µm]
  Mat3 turn;   ///< from a's frame to b's
  double clearance;

  Meeting(const Body& first, const Body& second, const Vec3& fromSecond, double wanted)
      : a(first),
        b(second),
        fromB(fromSecond),
        turn(second.rotation.transpose() * first.rotation),
        clearance(wanted) {}

  /// Map from the frame of a to that of b or, for the other side, from that of b to that of a.
  RelativeFrame frame(int side) const {
    const Body &sampled = side == 0 ? a : b, &surface = side == 0 ? b : a;
    const double ratio = sampled.scale / surface.scale;
    const Vec3 t = surface.rotation.transpose() * fromB / (side == 0 ? surface.scale : -surface.scale);
    RelativeFrame frame;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c)
        frame.m[3 * r + c] = static_cast<float>(ratio * (side == 0 ? turn(r, c) : turn(c, r)));
      frame.t[r] = static_cast<float>(t[r]);
    }
    frame.scale = static_cast<float>(ratio);
    return frame;
  }
};

bool ContactSolver::findContact(const Meeting& meeting, int side, bool coarsely, double margin,
                                ClusterMask& mask, Contact& contact, double& nearest,
                                ClusterMask& touched) const {
  const Body &sampled = side == 0 ? meeting.a : meeting.b, &surface = side == 0 ? meeting.b : meeting.a;
  const double clearance = meeting.clearance;
  ContactSums sums;
  const ContactViews& views = shapes_[sampled.shape].views();
  kernel_(coarsely ? views.coarseSamples : views.samples, meeting.frame(side),
          shapes_[surface.shape].views().field, static_cast<float>(clearance / surface.scale),
          static_cast<float>(margin / surface.scale), mask, sums);
  nearest = surface.scale * sums.nearest;
  touched = sums.touched;
  if (!(sums.weight > 0.0f)) return false;

  const double perWeight = 1.0 / sums.weight, perGradient = 1.0 / sums.gradient;
  const Vec3 point =
      surface.scale * surface.rotation * (Vec3(sums.point[0], sums.point[1], sums.point[2]) * perWeight);
  Vec3 normal = surface.rotation * (Vec3(sums.normal[0], sums.normal[1], sums.normal[2]) * perGradient);
  contact.depth = surface.scale * sums.deepest;
  if (contact.depth <= negligible) return false;
  const double coherence = normal.norm();
  const Vec3 fromSurface = side == 0 ? meeting.fromB : Vec3(-meeting.fromB);
  if (coherence < lockedNormal &&
      (contact.depth > shapes_[surface.shape].lockedDepth || clearance > clearance_)) {
    const double distance = fromSurface.norm();
    if (distance > 1e-9) normal += (1.0 - coherence) * fromSurface / distance;  // otherwise undefined
  }
  const double length = normal.norm();
  if (!(length > 1e-6)) return false;  // normals of samples cancel out
  contact.normal = normal / length;
  contact.backArm = point;
  contact.arm = point - fromSurface;
  return true;
}

void ContactSolver::move(Body& body, const Vec3& translation, const Vec3& rotation) const {
  const Freedom& freedom = species_[body.species].freedom;
  if (freedom.fixed) return;
  body.changed = body.touched = true;
  const double reach = shapes_[body.shape].radius * body.scale;
  Vec3 step = translation;
  double length = step.norm();
  if (length > largestStep * reach) {
    step *= largestStep * reach / length;
    length = largestStep * reach;
  }
  body.position += step;
  double angle = 0.0;
  if (rotate_) {
    Vec3 turn = rotation;
    angle = turn.norm();
    if (angle > largestTurn) {
      turn *= largestTurn / angle;
      angle = largestTurn;
    }
    const Vec3 half = 0.5 * turn;
    const Quaternion q = body.orientation;
    const Vec3 v = q.vec() + q.w() * half + half.cross(q.vec());
    body.orientation = Quaternion(q.w() - half.dot(q.vec()), v.x(), v.y(), v.z()).normalized();
    if (freedom.cone) {
      // Rotations whose quaternions are a chord c apart are 4 asin(c/2) <= 2.1 c apart for c <= 1.
      body.orientation = freedom.cone->nearest(body.orientation);
      const auto &now = body.orientation.coeffs(), &before = q.coeffs();
      angle = std::min(2.0, 2.1 * std::min((now - before).norm(), (now + before).norm()));
    }
    body.rotation = body.orientation.toRotationMatrix();
  }
  body.moved += length + reach * angle;
}

ContactSolver::Push ContactSolver::pushOf(const Contact& contact, Body& away, Body& back) const {
  away.overlap += contact.depth;
  back.overlap += contact.depth;
  const ShapeModel &a = shapes_[away.shape], &b = shapes_[back.shape];
  const bool isFixedA = isFixed(away), isFixedB = isFixed(back);
  const Vec3 turnA = contact.arm.cross(contact.normal), turnB = contact.backArm.cross(contact.normal);
  const double massA = isFixedA ? 0.0 : a.inverseMass, massB = isFixedB ? 0.0 : b.inverseMass;
  const double inertiaA = rotate_ && !isFixedA ? a.inverseInertia : 0.0;
  const double inertiaB = rotate_ && !isFixedB ? b.inverseInertia : 0.0;
  const double compliance = massA + massB + inertiaA * turnA.squaredNorm() + inertiaB * turnB.squaredNorm();
  const double impulse = omega_ * contact.depth / compliance;
  return {{impulse * massA * contact.normal, impulse * inertiaA * turnA},
          {-impulse * massB * contact.normal, -impulse * inertiaB * turnB}};
}

void ContactSolver::resolve(ContactPair& pair, std::vector<Body>& bodies, SweepSums& sums) const {
  Body &a = bodies[pair.first], &b = bodies[pair.second];
  if (isFixed(a) && isFixed(b)) return;
  const double moved = a.moved + b.moved;
  if (moved <= pair.apartUntil) return;
  const double clearance = clearance_ + pair.extraClearance - slack_;
  const Vec3 fromB = a.position - (b.position + displacement(pair.shift, period_));
  const bool quick = mayLookQuickly(pair);
  if (!quick) {
    const double apart = boundedGap(a, b, fromB);
    if (apart > clearance) {
      pair.apartUntil = static_cast<float>(moved + apart - clearance + negligible);
      return;
    }
  }

  const Meeting meeting(a, b, fromB, clearance);
  Contact contacts[2];
  bool touching[2];
  double nearest;
  if ((quick && findKnownContacts(pair, meeting, contacts, touching)) ||
      findContacts(pair, meeting, contacts, touching, nearest))
    resolve(contacts, touching, a, b, sums);
  else
    pair.apartUntil = static_cast<float>(moved + nearest - clearance + negligible);
}

double ContactSolver::boundedGap(const Body& a, const Body& b, const Vec3& fromB) const {
  const ShapeModel &modelA = shapes_[a.shape], &modelB = shapes_[b.shape];
  const double distance = fromB.norm();
  const double bySpheres = distance - a.scale * modelA.radius - b.scale * modelB.radius;
  if (bySpheres > clearance_ || !(distance > 1e-12)) return bySpheres;  // no direction
  const Vec3 direction = fromB / distance;
  return distance - a.scale * modelA.bound.support(a.rotation.transpose() * direction) -
         b.scale * modelB.bound.support(b.rotation.transpose() * direction);
}

void ContactSolver::resolve(const Contact (&contacts)[2], const bool (&touching)[2], Body& a, Body& b,
                            SweepSums& sums) const {
  Push pushes[2];
  for (int side = 0; side < 2; ++side) {
    if (!touching[side]) continue;
    sums.add(contacts[side].depth);
    pushes[side] = side == 0 ? pushOf(contacts[side], a, b) : pushOf(contacts[side], b, a);
  }
  const auto moveBy = [this](Body& body, const Motion& motion) { move(body, motion.step, motion.turn); };
  if (economical_ && touching[0] && touching[1]) {
    moveBy(a, pushes[0].away + pushes[1].back);
    moveBy(b, pushes[0].back + pushes[1].away);
    return;
  }
  if (touching[0]) {
    moveBy(a, pushes[0].away);
    moveBy(b, pushes[0].back);
  }
  if (touching[1]) {
    moveBy(b, pushes[1].away);
    moveBy(a, pushes[1].back);
  }
}

bool ContactSolver::mayLookQuickly(const ContactPair& pair) const {
  return !thoroughly_ && pair.quickLooks < (economical_ ? mostQuickLooksOfMany : mostQuickLooks) &&
         (pair.touched[0] | pair.touched[1]) != 0;
}

bool ContactSolver::findKnownContacts(ContactPair& pair, const Meeting& meeting, Contact (&contacts)[2],
                                      bool (&touching)[2]) const {
  ++pair.quickLooks;
  for (int side = 0; side < 2; ++side) {
    ClusterMask clusters = pair.touched[side], touched;
    double nearest;
    touching[side] = clusters != 0 &&
                     findContact(meeting, side, pair.coarse, 0.0, clusters, contacts[side], nearest, touched);
  }
  return touching[0] || touching[1];
}

bool ContactSolver::findContacts(ContactPair& pair, const Meeting& meeting, Contact (&contacts)[2],
                                 bool (&touching)[2], double& nearest) const {
  const double moved = meeting.a.moved + meeting.b.moved, clearance = meeting.clearance;
  const auto lookAt = [&](bool coarsely, double margin, ClusterMask(&masks)[2]) {
    double nearestOf[2];
    for (int side = 0; side < 2; ++side)
      touching[side] = findContact(meeting, side, coarsely, margin, masks[side], contacts[side],
                                   nearestOf[side], pair.touched[side]);
    nearest = std::min(nearestOf[0], nearestOf[1]);
    pair.quickLooks = 0;
    pair.coarse = coarsely;
    pair.deep =
        (touching[0] && contacts[0].depth > deepContact) || (touching[1] && contacts[1].depth > deepContact);
    return touching[0] || touching[1];
  };

  if (pair.deep) {
    ClusterMask all[2] = {allClusters, allClusters};
    const bool found = lookAt(true, 0.0, all);
    if (found && pair.deep) return true;
    if (coarsely_) {
      pair.deep = true;
      nearest = -std::numeric_limits<double>::infinity();  // coarse samples give no bound of the gap
      return found;
    }
  }
  if (moved < pair.masksUntil) {
    ClusterMask masks[2] = {pair.masks[0], pair.masks[1]};  // with margin 0, a full mask would be reduced
    const bool found = lookAt(false, 0.0, masks);
    nearest = std::min(nearest, clearance + (pair.masksUntil - moved));
    return found;
  }
  pair.masksUntil = static_cast<float>(moved + expectedMotion_);
  pair.masks[0] = pair.masks[1] = allClusters;
  return lookAt(false, expectedMotion_, pair.masks);
}

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

namespace {

/// Interpolated distances to an edge or corner, the sharpest feature of a wall, are too large by at most this
/// [spacings] (measured); to smoother walls by less.
constexpr double interpolationExcess = 0.26;

WallGrid gridOf(const SampledDistance& wall, const Vec3& center, double reach) {
  WallGrid grid;
  grid.bricks = wall.view();
  const Vec3 at = wall.nodeOf(center);
  const int below = static_cast<int>(reach / wall.spacing()) + 2;
  for (int k = 0; k < 3; ++k) {
    const int cells = BrickView::cells * grid.bricks.bricks[k];
    grid.base[k] = static_cast<int>(std::min(std::floor(at[k]) - below, cells - 1.0));
    grid.start[k] = static_cast<float>(at[k] - grid.base[k]);
    grid.first[k] = static_cast<float>(std::max(0, -grid.base[k]));
    // Slightly less, so that a node remains above.
    grid.last[k] = std::nextafter(static_cast<float>(cells - grid.base[k]), 0.0f);
  }
  return grid;
}

float orNone(double distance) {
  return static_cast<float>(std::min<double>(distance, WallForm::none));
}

WallForm formOf(const ClosedFormWall& wall, const Vec3& center) {
  WallForm form;
  const Vec3 fromAxis = wall.across.cwiseProduct(center - wall.center);
  form.radius = static_cast<float>(wall.radius);
  form.excess = static_cast<float>(wall.radius * wall.radius - fromAxis.squaredNorm());
  for (int k = 0; k < 3; ++k) {
    form.across[k] = static_cast<float>(wall.across[k]);
    form.fromAxis[k] = static_cast<float>(fromAxis[k]);
    form.toLo[k] = orNone(center[k] - wall.lo[k]);
    form.toHi[k] = orNone(wall.hi[k] - center[k]);
  }
  return form;
}

}  // namespace

WallField::WallField(const Wall& wall, const Box& region) : form_(wall.closedForm()) {
  if (form_) return;
  sampled_.emplace(Sampled{wall.coarselySampled(region), wall.sampled(region)});
  slack_ = wall.slack() + interpolationExcess * sampled_->coarse.spacing();
}

double WallField::distance(const Vec3& p) const {
  return form_ ? form_->distance(p).distance : sampled_->coarse.sample(p).distance;
}

WallFrame WallField::frameOf(const Body& body, double reach, bool deep) const {
  WallFrame frame{};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) frame.m[3 * r + c] = static_cast<float>(body.scale * body.rotation(r, c));
  frame.scale = static_cast<float>(body.scale);
  frame.slack = static_cast<float>(slack_);
  if (form_) {
    frame.kind = WallFrame::Kind::form;
    frame.form = formOf(*form_, body.position);
    return frame;
  }
  frame.kind = deep ? WallFrame::Kind::coarse : WallFrame::Kind::sampled;
  frame.coarse = gridOf(sampled_->coarse, body.position, reach);
  if (!deep) frame.fine = gridOf(sampled_->fine, body.position, reach);
  return frame;
}

}  // namespace packmesh
