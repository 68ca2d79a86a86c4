// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/vessel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "packMesh/container/surface_wall.h"
#include "packMesh/container/vessel_ends.h"
#include "packMesh/core/error.h"
#include "packMesh/core/vector_text.h"
#include "packMesh/mesh/closest_point.h"
#include "packMesh/mesh/mesh_intersection.h"
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
  Vessel(double volume, const TriangleMesh& closed, const TriangleMesh& wall,
         const std::optional<VesselEnds>& ends, double detail)
      : volume_(volume),
        ends_(ends),
        detail_(detail),
        wall_(wall, ends ? ends->axis : 0, ends ? ends->lo : 0.0,
              ends && ends->periodic ? ends->hi - ends->lo : 0.0),
        closed_(closed),
        bounds_(boundingBox(closed)),
        distances_(periodic() ? withImages(wall, ends_->axis, ends_->lo, ends_->hi, imageReach) : wall) {
    if (ends_) {
      bounds_.lo[ends_->axis] = ends_->lo;
      bounds_.hi[ends_->axis] = ends_->hi;
    }
  }

  Box bounds() const override { return bounds_; }
  Vec3 period() const override {
    return periodic() ? Vec3((ends_->hi - ends_->lo) * Vec3::Unit(ends_->axis)) : Vec3(Vec3::Zero());
  }
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
      const double period = ends_->periodic ? ends_->hi - ends_->lo : 0.0;
      const double shift = ends_->periodic ? period * wall_.imageOf(0.5 * (x.front() + x.back())) : 0.0;
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
    double toEnds = gapOfInterest;
    if (ends_ && !ends_->periodic) {
      double lo = std::numeric_limits<double>::infinity(), hi = -lo;
      for (std::size_t i = 0; i < cell.vertexCount(); ++i) {
        const double x = cell.vertex(i)[ends_->axis];
        lo = std::min(lo, x);
        hi = std::max(hi, x);
      }
      toEnds = std::min(lo - ends_->lo, ends_->hi - hi);
      if (!(toEnds > 0.0)) {
        WallVerdict verdict;
        verdict.violation = "meets an end of the vessel";
        return verdict;
      }
    }
    return wall_.examine(cell, gapOfInterest, toEnds, [&](const Vec3& p) { return contains(p); });
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

  bool periodic() const { return ends_ && ends_->periodic; }

  bool contains(const Vec3& p) const {
    const int image = periodic() ? wall_.imageOf(p[ends_->axis]) : 0;
    return isInside(wall_.shifted(p, -image), closed_, Placement());
  }

  double volume_;
  std::optional<VesselEnds> ends_;
  double detail_;
  SurfaceWall wall_;      ///< without caps if the vessel has ends
  MeshHierarchy closed_;  ///< surface of the lumen, closed at its ends
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
  const double volume = signedVolume(surface);
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
  if (ends->periodic) requireSameOutlines(closed, ends->axis, ends->lo, ends->hi);
  const TriangleMesh wall = ends->periodic ? opened.wallUntil(ends->lo, ends->hi)
                                           : opened.wallUntil(ends->lo - closedReach, ends->hi + closedReach);
  return std::make_unique<Vessel>(volume, closed, wall, ends, detail);
}

}  // namespace packmesh
