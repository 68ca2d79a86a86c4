// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/vessel.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "packMesh/container/vessel_ends.h"
#include "packMesh/core/error.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/core/vector_text.h"
#include "packMesh/mesh/closest_point.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/mesh_tree.h"
#include "packMesh/mesh/signed_distances.h"

namespace packmesh {
namespace {

/// Distances beyond the ends of a periodic vessel take its images into account up to this far from the ends
/// [µm]: more than the radius of any blood cell.
constexpr double imageReach = 12.0;

/// For distances, the wall of a vessel with closed ends is continued this far behind them [µm].
constexpr double closedReach = 2.0;

class Vessel final : public Container, public Wall {
 public:
  /// @param closed the same as `wall` if there are no ends
  Vessel(double volume, const TriangleMesh& closed, const TriangleMesh& wall,
         const std::optional<VesselEnds>& ends, double detail)
      : volume_(volume),
        ends_(ends),
        detail_(detail),
        axis_(ends ? ends->axis : 0),
        period_(ends && ends->periodic ? ends->hi - ends->lo : 0.0),
        wall_(wall),
        wallBox_(boundingBox(wall)),
        ownClosed_(ends ? std::make_unique<const MeshHierarchy>(closed) : nullptr),
        closed_(ends ? *ownClosed_ : wall_),
        bounds_(boundingBox(closed)),
        distances_(periodic() ? withImages(wall, ends_->axis, ends_->lo, ends_->hi, imageReach) : wall) {
    if (ends_) {
      bounds_.lo[ends_->axis] = ends_->lo;
      bounds_.hi[ends_->axis] = ends_->hi;
    }
  }

  Box bounds() const override { return bounds_; }
  Vec3 period() const override { return period_ * Vec3::Unit(axis_); }
  double volume() const override { return volume_; }
  const Wall* wall() const override { return this; }
  TriangleMesh surface() const override { return closed_.mesh(); }

  std::string describe() const override {
    const Vec3 size = bounds_.size();
    std::string text = "vessel " + toText(size.x()) + " x " + toText(size.y()) + " x " + toText(size.z()) +
                       " µm of " + std::to_string(closed_.mesh().triangles.size()) + " triangles";
    if (ends_)
      text += std::string(periodic() ? ", periodic along " : ", closed along ") + axisName[ends_->axis];
    return text;
  }

  WallDistance distance(const Vec3& p) const override {
    if (!ends_) return lumenSide(p);
    const int k = ends_->axis;
    const double lo = ends_->lo, hi = ends_->hi;
    Vec3 at = p;
    if (ends_->periodic) {
      at[k] -= (hi - lo) * std::floor((at[k] - lo) / (hi - lo));
      WallDistance result = lumenSide(at);
      result.distance = std::min(result.distance, toEnds(at[k]));
      return result;
    }
    at[k] = std::clamp(at[k], lo, hi);
    WallDistance result = lumenSide(at);
    if (p[k] - lo < result.distance) result = {p[k] - lo, Vec3::Unit(k)};
    if (hi - p[k] < result.distance) result = {hi - p[k], -Vec3::Unit(k)};
    return result;
  }

  WallDistance distanceToSides(const Vec3& p, const std::array<bool, 3>& ends) const override {
    if (!ends_ || ends_->periodic || !ends[ends_->axis]) return distance(p);
    Vec3 at = p;
    at[ends_->axis] = std::clamp(at[ends_->axis], ends_->lo, ends_->hi);
    return lumenSide(at);
  }

  double samplingSpacing() const override { return detail_; }

  void sample(const NodeBlock& block, float* distances) const override {
    std::array<std::vector<double>, 3> at;
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < block.nodes[k]; ++i) at[k].push_back(block.origin[k] + block.spacing * i);
    std::vector<double> along;
    if (ends_) {
      std::vector<double>& x = at[ends_->axis];
      const double shift = period_ * imageOf(0.5 * (x.front() + x.back()));
      for (double& v : x) v -= shift;
      along = x;
      if (!ends_->periodic)
        for (double& v : x) v = std::clamp(v, ends_->lo, ends_->hi);
    }
    distances_.sample(at, true, distances);
    std::size_t n = 0;
    for (int k = 0; k < block.nodes[2]; ++k)
      for (int j = 0; j < block.nodes[1]; ++j)
        for (int i = 0; i < block.nodes[0]; ++i, ++n) {
          distances[n] = -distances[n];
          if (!ends_) continue;
          const double x = along[ends_->axis == 0 ? i : ends_->axis == 1 ? j : k];
          distances[n] = std::min(distances[n], static_cast<float>(toEnds(x)));
        }
  }

  WallVerdict examine(const PlacedHierarchy& cell, double gapOfInterest) const override {
    Box box;
    for (std::size_t i = 0; i < cell.vertexCount(); ++i) box.add(cell.vertex(i));
    double nearest = gapOfInterest;
    if (ends_ && !ends_->periodic) {
      const double toEnds = std::min(box.lo[axis_] - ends_->lo, ends_->hi - box.hi[axis_]);
      if (!(toEnds > 0.0)) return {"meets an end of the vessel"};
      nearest = std::min(toEnds, nearest);
    }
    // A mesh can extend beyond the ends between which it repeats: examine one more image on either side.
    const Box reach = box.grownBy(gapOfInterest);
    const int first = imageOf(reach.lo[axis_]) - periodic(), last = imageOf(reach.hi[axis_]) + periodic();
    for (int image = first; image <= last; ++image) {
      const Placement moved{Mat3::Identity(), shifted(Vec3::Zero(), image)};
      if (!reach.grownBy(tolerance::culling)
               .meets({shifted(wallBox_.lo, image), shifted(wallBox_.hi, image)}))
        continue;
      const double gap = surfaceGap(cell.hierarchy, cell.placement, wall_, moved, nearest);
      if (gap == 0.0) return {"meets the wall"};
      nearest = std::min(nearest, gap);
    }
    for (const int v : cell.hierarchy.tree().samples)
      if (!contains(cell.vertex(v))) return {"is outside the lumen"};
    for (int image = first; image <= last; ++image)
      for (const int v : wall_.tree().samples) {
        const Vec3 sample = shifted(wall_.mesh().vertices[v], image);
        if (box.contains(sample) && isInside(sample, cell.hierarchy, cell.placement))
          return {"encloses part of the wall"};
      }
    WallVerdict verdict;
    if (nearest < gapOfInterest) verdict.gap = nearest;
    return verdict;
  }

 private:
  WallDistance lumenSide(const Vec3& p) const {
    const ClosestPoint& surface = distances_.surface();
    const ClosestPoint::Nearest nearest = surface.nearest(p);
    const int side = surface.side(p, nearest);  // +1: outside the lumen
    const Vec3 away = p - nearest.point;
    Vec3 gradient = nearest.distance > 0.0 ? Vec3(-side * away / nearest.distance) : -surface.normal(nearest);
    return {-side * nearest.distance, gradient};
  }

  /// Distance of x along the axis to the ends of the vessel [µm]; if it is periodic, to the limit beyond
  /// which its images are not taken into account.
  double toEnds(double x) const {
    return std::min(x - ends_->lo, ends_->hi - x) + (ends_->periodic ? imageReach : 0.0);
  }

  bool periodic() const { return period_ > 0.0; }

  /// The image of the lumen that contains x; 0 if it is not periodic.
  int imageOf(double x) const {
    return periodic() ? static_cast<int>(std::floor((x - ends_->lo) / period_)) : 0;
  }

  /// p in image `image`.
  Vec3 shifted(Vec3 p, int image) const {
    if (image != 0) p[axis_] += image * period_;
    return p;
  }

  bool contains(const Vec3& p) const {
    return isInside(shifted(p, -imageOf(p[axis_])), closed_, Placement());
  }

  double volume_;
  std::optional<VesselEnds> ends_;
  double detail_;
  int axis_;            ///< of the ends; 0 without
  double period_;       ///< along the axis [µm]; 0: not periodic
  MeshHierarchy wall_;  ///< that cells must not meet; without caps if the vessel has ends
  Box wallBox_;
  std::unique_ptr<const MeshHierarchy> ownClosed_;  ///< where the wall has no caps
  const MeshHierarchy& closed_;                     ///< surface of the lumen, closed at its ends
  Box bounds_;
  SignedDistances distances_;  ///< distances to the wall and its continuation or images
};

}  // namespace

std::unique_ptr<Container> makeVessel(const TriangleMesh& surface, const std::optional<VesselEnds>& ends,
                                      double detail) {
  if (surface.triangles.empty()) throw MeshError("the mesh of the vessel has no triangles");
  if (!(detail > 0.0) || !std::isfinite(detail))
    throw InputError("the spacing of the vessel's distances must be positive and finite; found " +
                     toText(detail) + " µm");
  double volume = signedVolume(surface);
  if (!ends) return std::make_unique<Vessel>(volume, surface, surface, ends, detail);

  if (ends->axis < 0 || ends->axis > 2)
    throw InputError("the axis of the vessel must be 0, 1 or 2; found " + std::to_string(ends->axis));
  if (!(ends->lo < ends->hi) || !std::isfinite(ends->hi - ends->lo))
    throw InputError("the end of the vessel must lie beyond its beginning; found " +
                     std::string(axisName[ends->axis]) + " = " + toText(ends->lo) + " to " +
                     toText(ends->hi) + " µm");
  const OpenedVessel opened = openVessel(surface, ends->axis);
  if (!(ends->lo < opened.hi && ends->hi > opened.lo))
    throw InputError("the vessel's mesh (" + std::string(axisName[ends->axis]) + " = " + toText(opened.lo) +
                     " to " + toText(opened.hi) + " µm) lies outside the container (" + toText(ends->lo) +
                     " to " + toText(ends->hi) + " µm)");
  const TriangleMesh closed = opened.closedUntil(ends->lo, ends->hi);
  if (ends->periodic) {
    requireSameOutlines(closed, ends->axis, ends->lo, ends->hi);
    volume += opened.capArea(0) * (opened.lo - ends->lo) + opened.capArea(1) * (ends->hi - opened.hi);
  }
  const TriangleMesh wall = ends->periodic ? opened.wallUntil(ends->lo, ends->hi)
                                           : opened.wallUntil(ends->lo - closedReach, ends->hi + closedReach);
  return std::make_unique<Vessel>(volume, closed, wall, ends, detail);
}

}  // namespace packmesh
