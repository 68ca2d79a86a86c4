// SPDX-License-Identifier: AGPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>

#include "packMesh/stages/relaxation/contact.h"

namespace packmesh {
namespace {

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

/// How the wall is searched for.
struct WallSearch {
  const Wall& wall;
  double slack;      ///< clusters are culled only this much further away [µm]
  double clearance;  ///< [µm]
  double margin;     ///< [µm]
};

/// Looks at the clusters in `mask`; returns those that may be nearer to the wall than clearance + margin and
/// lowers `nearest` to a bound of the distance of all points looked at.
ClusterMask findWallContacts(const Body& body, const SampleView& samples, const WallSearch& search,
                             ClusterMask mask, WallContacts& contacts, double& nearest) {
  const Mat3 toWorld = body.scale * body.rotation;
  ClusterMask near = 0;
  for (int c = 0; c < samples.clusters; ++c) {
    const ClusterMask bit = ClusterMask{1} << (c >> samples.bitShift);
    if (!(mask & bit)) continue;
    const Vec3 center =
        body.position + toWorld * Vec3(samples.centerX[c], samples.centerY[c], samples.centerZ[c]);
    const double apart =
        search.wall.distance(center).distance - search.slack - body.scale * samples.radius[c];
    if (apart < search.clearance + search.margin) near |= bit;
    if (apart > search.clearance) {
      nearest = std::min(nearest, apart);
      continue;
    }
    for (int k = c * SamplePoints::width; k < (c + 1) * SamplePoints::width; ++k) {
      const Vec3 arm = toWorld * Vec3(samples.x[k], samples.y[k], samples.z[k]);
      const WallDistance at = search.wall.distance(body.position + arm);
      nearest = std::min(nearest, at.distance);
      if (at.distance < search.clearance) contacts.add(arm, at.gradient, search.clearance - at.distance);
    }
  }
  return near;
}

}  // namespace

void ContactSolver::resolveWall(Body& body, SweepSums& sums) const {
  const SpeciesModel& model = models_[body.species];
  if (model.wall == nullptr || body.moved < body.awayFromWallWhile) return;
  const double clearance = wallClearance_ + body.extraWallClearance - slack_;
  const double reach = model.radius * body.scale;
  WallSearch search{*model.wall, std::min(model.wall->slack(), largestSlack * reach), clearance, 0.0};
  const double atCenter = model.wall->distance(body.position).distance - search.slack;
  if (atCenter > reach + clearance) {
    body.awayFromWallWhile = atCenter - reach - clearance - body.moved;
    return;
  }

  WallContacts contacts;
  double nearest = reach + clearance;
  if (body.deepInWall) {
    findWallContacts(body, model.coarseSamples, search, allClusters, contacts, nearest);
    body.deepInWall = contacts.deepest() > deepContact;
  }
  if (!body.deepInWall) {
    contacts = WallContacts();
    nearest = reach + clearance;
    const bool everywhere = !(body.moved < body.wallMaskWhile);
    if (everywhere) {
      body.wallMask = allClusters;
      body.wallMaskWhile = std::max(0.5 * expectedMotion_, 1.5 * body.moved);
      search.margin = body.moved + body.wallMaskWhile;
    }
    const ClusterMask near = findWallContacts(body, model.samples, search, body.wallMask, contacts, nearest);
    if (everywhere) body.wallMask = near;
    nearest = std::min(nearest, clearance + (body.wallMaskWhile - body.moved));
    body.deepInWall = contacts.deepest() > deepContact;
  }
  if (contacts.begin() == contacts.end()) {
    body.awayFromWallWhile = nearest - clearance - body.moved;
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
