// SPDX-License-Identifier: AGPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>

#include "packMesh/stages/relaxation/contact.h"

namespace packmesh {
namespace {

/// How long the clusters that can touch the wall are remembered: as for pairs (contact.cpp) [sweeps; µm].
constexpr double marginSweeps = 6.0, smallestMargin = 0.02, largestMargin = 0.3;

/// Cells deeper in the wall than this are pushed back by coarse samples [µm].
constexpr double deepContact = 0.3;

/// Culling trusts sampled distances to this [fraction of a cell's radius]; what slips through is found by the
/// exact test and given more clearance.
constexpr double largestSlack = 0.02;

/// Points that touch the wall from about the same direction.
struct WallContact {
  Vec3 arm = Vec3::Zero(), normal = Vec3::Zero();  ///< weighted sums
  double weight = 0.0, depth = 0.0;
};

/// In a narrow lumen a cell touches opposite walls at once, so there is a contact for each direction.
class WallContacts {
 public:
  void add(const Vec3& arm, const Vec3& normal, double depth) {
    constexpr double alike = 0.7;  // cosine
    int slot = 0;
    while (slot < count_ && contacts_[slot].normal.dot(normal) < alike * contacts_[slot].weight) ++slot;
    if (slot == static_cast<int>(contacts_.size())) --slot;
    count_ = std::max(count_, slot + 1);
    WallContact& c = contacts_[slot];
    c.arm += depth * arm;
    c.normal += depth * normal;
    c.weight += depth;
    c.depth = std::max(c.depth, depth);
  }
  const WallContact* begin() const { return contacts_.data(); }
  const WallContact* end() const { return contacts_.data() + count_; }
  double deepest() const {
    double depth = 0.0;
    for (const WallContact& c : *this) depth = std::max(depth, c.depth);
    return depth;
  }

 private:
  std::array<WallContact, 4> contacts_;
  int count_ = 0;
};

/// Looks at the clusters in `mask`; returns those nearer to the wall than clearance + margin and lowers
/// `nearest` to the distance of the nearest point.
ClusterMask findWallContacts(const Body& body, const SampleView& samples, const Wall& wall, double slack,
                             double clearance, double margin, ClusterMask mask, WallContacts& contacts,
                             double& nearest) {
  const Mat3 toWorld = body.scale * body.rotation;
  ClusterMask near = 0;
  for (int c = 0; c < samples.clusters; ++c) {
    const ClusterMask bit = ClusterMask{1} << c / samples.clustersPerBit;
    if (!(mask & bit)) continue;
    if (mask == allClusters) {
      const Vec3 center =
          body.position + toWorld * Vec3(samples.centerX[c], samples.centerY[c], samples.centerZ[c]);
      const double apart = wall.distance(center).distance - slack - body.scale * samples.radius[c];
      nearest = std::min(nearest, std::max(apart, clearance));
      if (apart > clearance + margin) continue;
    }
    for (int k = c * SamplePoints::width; k < (c + 1) * SamplePoints::width; ++k) {
      const Vec3 arm = toWorld * Vec3(samples.x[k], samples.y[k], samples.z[k]);
      const WallDistance at = wall.distance(body.position + arm);
      nearest = std::min(nearest, at.distance);
      if (at.distance < clearance + margin) near |= bit;
      if (at.distance < clearance) contacts.add(arm, at.gradient, clearance - at.distance);
    }
  }
  return near;
}

}  // namespace

void ContactSolver::resolveWall(Body& body, SweepSums& sums) const {
  const SpeciesModel& model = models_[body.species];
  if (model.wall == nullptr || body.travel < body.awayFromWallUntil) return;
  const double clearance = wallClearance_ + body.extraWallClearance - slack_;
  const double reach = model.radius * body.scale;
  const double slack = std::min(model.wall->slack(), largestSlack * reach);
  const double atCenter = model.wall->distance(body.position).distance - slack;
  if (atCenter > reach + clearance) {
    body.awayFromWallUntil = body.travel + (atCenter - reach - clearance);
    return;
  }

  WallContacts contacts;
  double nearest = reach + clearance;
  const double rate = body.travel - body.lastWallTravel;
  body.lastWallTravel = body.travel;
  if (body.deepInWall) {
    findWallContacts(body, model.coarseSamples, *model.wall, slack, clearance, 0.0, allClusters, contacts,
                     nearest);
    body.deepInWall = contacts.deepest() > deepContact;
  }
  if (!body.deepInWall) {
    contacts = WallContacts();
    nearest = reach + clearance;
    double margin = 0.0;
    if (!(body.travel < body.wallMaskUntil)) {
      margin = std::clamp(marginSweeps * rate, smallestMargin, largestMargin);
      body.wallMask = allClusters;
      body.wallMaskUntil = body.travel + margin;
    }
    const ClusterMask near = findWallContacts(body, model.samples, *model.wall, slack, clearance, margin,
                                              body.wallMask, contacts, nearest);
    if (body.wallMask == allClusters) body.wallMask = near;
    nearest = std::min(nearest, clearance + (body.wallMaskUntil - body.travel));
    body.deepInWall = contacts.deepest() > deepContact;
  }
  if (contacts.begin() == contacts.end()) {
    body.awayFromWallUntil = body.travel + std::max(0.0, nearest - clearance);
    return;
  }

  const double inertia = rotate_ ? model.inverseInertia : 0.0;
  for (const WallContact& c : contacts) {
    sums.add(c.depth);
    body.overlap += c.depth;
    const double length = c.normal.norm();
    if (!(length > 0.0)) continue;
    const Vec3 normal = c.normal / length;
    const Vec3 turn = (c.arm / c.weight).cross(normal);
    const double impulse = omega_ * c.depth / (model.inverseMass + inertia * turn.squaredNorm());
    move(body, impulse * model.inverseMass * normal, impulse * inertia * turn);
  }
}

}  // namespace packmesh
