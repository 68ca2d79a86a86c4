// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Parts of a lumen: those that bodies and planes bound, and their volumes.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "packMesh/container/container.h"

namespace packmesh {

class Region {
 public:
  virtual ~Region() = default;

  /// Positive inside [µm]; exact near the surface, elsewhere a lower bound of the distance (as for walls).
  virtual WallDistance distance(const Vec3& p) const = 0;
  bool contains(const Vec3& p) const { return distance(p).distance >= 0.0; }

  /// A box that contains the part of the region within the lumen's bounds.
  virtual const Box& bounds() const = 0;
};

/// Fraction of a box on the inner side of a plane at this distance from its centre: exact for planes
/// perpendicular to an axis; otherwise that of a slab as thick as the box is along the normal.
inline double shareInside(const WallDistance& plane, const Vec3& size) {
  if (!std::isfinite(plane.distance)) return 1.0;
  const double thickness = plane.gradient.cwiseAbs().dot(size) / std::max(plane.gradient.norm(), 1e-12);
  return std::clamp(0.5 + plane.distance / thickness, 0.0, 1.0);
}

/// Volume of the part of a box on the inner side of surfaces [µm³]: 0 or all of it if no surface can cut the
/// box, the sum over its octants if it can still be halved, an estimate otherwise.
/// @param nearest distance to the nearest surface from the centre of the box
/// @param reach distance from the centre within which a surface could cut the box [µm]
/// @param depth number of times the box can still be halved
/// @param ofPart (octant, depth) -> volume
template <class OfPart>
double volumeByHalving(const Box& box, const WallDistance& nearest, double reach, int depth,
                       const OfPart& ofPart) {
  if (nearest.distance < -reach) return 0.0;
  if (nearest.distance > reach || depth == 0) return box.volume() * shareInside(nearest, box.size());
  const Vec3 center = box.center();
  double volume = 0.0;
  for (int octant = 0; octant < 8; ++octant) {
    Box part = box;
    for (int k = 0; k < 3; ++k) ((octant >> k & 1) ? part.lo : part.hi)[k] = center[k];
    volume += ofPart(part, depth - 1);
  }
  return volume;
}

/// The part of a lumen inside a body, which repeats along the lumen's periodic axes.
class BodyRegion final : public Region {
 public:
  /// @param bounds, period of the lumen [µm]
  BodyRegion(std::shared_ptr<const Container> body, const Box& bounds, const Vec3& period);

  WallDistance distance(const Vec3& p) const override;
  const Box& bounds() const override { return bounds_; }

 private:
  std::shared_ptr<const Container> body_;
  std::vector<Vec3> shifts_;  ///< translations to the periodic images
  Box bounds_;
};

/// The part of a lumen beyond a plane; along a periodic axis that the plane cuts, as far as the period ends.
class HalfSpace final : public Region {
 public:
  /// @param normal unit vector, into the region
  /// @param bounds, period of the lumen [µm]
  HalfSpace(const Vec3& point, const Vec3& normal, const Box& bounds, const Vec3& period);

  WallDistance distance(const Vec3& p) const override;
  const Box& bounds() const override { return bounds_; }

 private:
  Vec3 point_, normal_;
  std::vector<Vec3> shifts_;
  std::vector<int> ends_;  ///< periodic axes that the plane cuts
  Box lumen_, bounds_;
};

/// The part of a lumen inside one region and outside others.
class RegionDifference final : public Region {
 public:
  /// @param inside nullptr: everything
  /// @param bounds of the lumen [µm]
  RegionDifference(std::shared_ptr<const Region> inside, std::vector<std::shared_ptr<const Region>> outside,
                   const Box& bounds)
      : inside_(std::move(inside)),
        outside_(std::move(outside)),
        bounds_(inside_ ? inside_->bounds() : bounds) {}

  WallDistance distance(const Vec3& p) const override;
  const Box& bounds() const override { return bounds_; }

 private:
  std::shared_ptr<const Region> inside_;
  std::vector<std::shared_ptr<const Region>> outside_;
  Box bounds_;
};

/// Volume of the part of the region in the lumen [µm³], continued ends of a vessel included: cubes crossed by
/// either surface are halved, to an accuracy of about 1e-4 of the lumen (4e-4 without a closed form).
double volumeInLumen(const Region& region, const Container& lumen);

}  // namespace packmesh
