// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/vessel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "packMesh/core/error.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/core/vector.h"
#include "packMesh/mesh/closest_point.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/mesh_tree.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {
namespace {

using Segment = std::array<Vec2, 2>;

double distanceToSegment(const Vec2& p, const Segment& s) {
  const Vec2 along = s[1] - s[0];
  const double squared = along.squaredNorm();
  const double t = squared > 0.0 ? std::clamp((p - s[0]).dot(along) / squared, 0.0, 1.0) : 0.0;
  return (s[0] + t * along - p).norm();
}

/// The point of `from` furthest from `to`, and its distance.
std::pair<double, Vec2> furthest(const std::vector<Segment>& from, const std::vector<Segment>& to) {
  TriangleMesh segments;  // for the search: their boxes are those of triangles with two equal corners
  for (const Segment& t : to) {
    const int n = static_cast<int>(segments.vertices.size());
    for (const Vec2& p : t) segments.vertices.emplace_back(p.x(), p.y(), 0.0);
    segments.triangles.push_back({n, n + 1, n + 1});
  }
  const TriangleTree tree(segments);
  std::pair<double, Vec2> worst(0.0, Vec2::Zero());
  for (const Segment& s : from)
    for (const Vec2& p : {s[0], Vec2(0.5 * (s[0] + s[1])), s[1]}) {
      double nearest = std::numeric_limits<double>::infinity();
      tree.visitNearer({p.x(), p.y(), 0.0}, nearest, [&](int t) {
        nearest = std::min(nearest, distanceToSegment(p, to[t]));
        return nearest * nearest;
      });
      if (nearest > worst.first) worst = {nearest, p};
    }
  return worst;
}

/// Separates wall and caps; an end can have no caps.
OpenedVessel takenApart(const TriangleMesh& surface, int axis) {
  const Box box = boundingBox(surface);
  const double near = tolerance::flatCapFraction * box.size().norm();
  OpenedVessel out;
  out.mesh.vertices = surface.vertices;
  out.axis = axis;
  out.lo = box.lo[axis];
  out.hi = box.hi[axis];
  for (const Triangle& t : surface.triangles) {
    bool low = true, high = true;
    for (const int v : t) {
      low &= surface.vertices[v][axis] <= out.lo + near;
      high &= surface.vertices[v][axis] >= out.hi - near;
    }
    if (low)
      out.caps[0].push_back(t);
    else if (high)
      out.caps[1].push_back(t);
    else
      out.mesh.triangles.push_back(t);
  }
  return out;
}

}  // namespace

bool hasFlatEnds(const TriangleMesh& surface, int axis) {
  const OpenedVessel opened = takenApart(surface, axis);
  return !opened.caps[0].empty() && !opened.caps[1].empty();
}

OpenedVessel openVessel(const TriangleMesh& surface, int axis) {
  OpenedVessel out = takenApart(surface, axis);
  for (int end = 0; end < 2; ++end)
    if (out.caps[end].empty())
      throw MeshError("the vessel has no flat end perpendicular to " + std::string(axisName[axis]) + " at " +
                      axisName[axis] + " = " + toText(end == 0 ? out.lo : out.hi) +
                      " µm: the mesh must be closed there by triangles in one plane");
  return out;
}

double OpenedVessel::capArea(int end) const {
  double twice = 0.0;
  for (const Triangle& t : caps[end]) {
    const Vec3& a = mesh.vertices[t[0]];
    twice += (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a)[axis];
  }
  return 0.5 * std::abs(twice);
}

TriangleMesh OpenedVessel::continued(double newLo, double newHi, bool closed) const {
  TriangleMesh out = mesh;
  for (int end = 0; end < 2; ++end) {
    const double target = end == 0 ? newLo : newHi;
    const bool further = end == 0 ? target < lo : target > hi;
    if (!further) {
      if (closed) out.triangles.insert(out.triangles.end(), caps[end].begin(), caps[end].end());
      continue;
    }
    // Copies of the vertices of the cap, in the target plane.
    std::vector<int> copy(mesh.vertices.size(), -1);
    std::vector<std::pair<int, int>> sides;
    for (const Triangle& t : caps[end])
      for (int k = 0; k < 3; ++k) {
        if (copy[t[k]] < 0) {
          copy[t[k]] = static_cast<int>(out.vertices.size());
          out.vertices.push_back(mesh.vertices[t[k]]);
          out.vertices.back()[axis] = target;
        }
        sides.emplace_back(t[k], t[(k + 1) % 3]);
      }
    // A strip of wall replaces the border of the cap.
    std::sort(sides.begin(), sides.end());
    for (const auto& [a, b] : sides)
      if (!std::binary_search(sides.begin(), sides.end(), std::pair(b, a)))
        out.triangles.insert(out.triangles.end(), {{a, b, copy[b]}, {a, copy[b], copy[a]}});
    if (closed)
      for (const Triangle& t : caps[end]) out.triangles.push_back({copy[t[0]], copy[t[1]], copy[t[2]]});
  }
  removeUnusedVertices(out);
  return out;
}

std::vector<Segment> outlineAt(const TriangleMesh& mesh, int axis, double x) {
  std::vector<Segment> outline;
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Vec2 ends[2];
    int found = 0;
    for (int k = 0; k < 3; ++k) {
      // Both triangles at an edge compute the same point, from the same vertices in the same order.
      const auto [from, to] = std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]);
      const Vec3 &a = mesh.vertices[from], &b = mesh.vertices[to];
      if ((a[axis] < x) == (b[axis] < x)) continue;
      const double s = (x - a[axis]) / (b[axis] - a[axis]);
      ends[found++] = {a[u] + s * (b[u] - a[u]), a[v] + s * (b[v] - a[v])};
    }
    if (found == 2) outline.push_back({ends[0], ends[1]});
  }
  return outline;
}

void requireSameOutlines(const TriangleMesh& closed, int axis, double lo, double hi) {
  // Slightly inside, where the mesh certainly extends to.
  const double inset = tolerance::flatCapFraction * boundingBox(closed).size().norm();
  const std::vector<Segment> low = outlineAt(closed, axis, lo + inset),
                             high = outlineAt(closed, axis, hi - inset);
  const std::string where =
      std::string(" (") + axisName[axis] + " = " + toText(lo) + " and " + toText(hi) + " µm)";
  if (low.empty() || high.empty())
    throw MeshError("a periodic vessel must extend to both of its ends" + where + ", but its mesh does not");
  Vec2 least = Vec2::Constant(std::numeric_limits<double>::infinity()), most = -least;
  for (const std::vector<Segment>* outline : {&low, &high})
    for (const Segment& s : *outline) {
      least = least.cwiseMin(s[0]).cwiseMin(s[1]);
      most = most.cwiseMax(s[0]).cwiseMax(s[1]);
    }
  const double allowed = tolerance::sameOutlineFraction * (most - least).norm();
  for (int side = 0; side < 2; ++side) {
    const auto [distance, at] = side == 0 ? furthest(low, high) : furthest(high, low);
    if (distance > allowed)
      throw MeshError("the two ends of a periodic vessel must have the same outline" + where + ", but at (" +
                      axisName[(axis + 1) % 3] + ", " + axisName[(axis + 2) % 3] + ") = (" + toText(at.x()) +
                      ", " + toText(at.y()) + ") they differ by " + toText(distance, 3) + " µm, more than " +
                      toText(allowed, 3) + " µm");
  }
}

TriangleMesh withImages(const TriangleMesh& wall, int axis, double lo, double hi, double reach) {
  TriangleMesh out = wall;
  const double period = hi - lo;
  const int images = static_cast<int>(std::ceil(reach / period));
  for (int image = -images; image <= images; ++image) {
    if (image == 0) continue;
    std::vector<int> copy(wall.vertices.size(), -1);
    for (const Triangle& t : wall.triangles) {
      double first = std::numeric_limits<double>::infinity(), last = -first;
      for (const int v : t) {
        first = std::min(first, wall.vertices[v][axis] + image * period);
        last = std::max(last, wall.vertices[v][axis] + image * period);
      }
      if (first > hi + reach || last < lo - reach) continue;
      Triangle shifted;
      for (int k = 0; k < 3; ++k) {
        if (copy[t[k]] < 0) {
          copy[t[k]] = static_cast<int>(out.vertices.size());
          out.vertices.push_back(wall.vertices[t[k]]);
          out.vertices.back()[axis] += image * period;
        }
        shifted[k] = copy[t[k]];
      }
      out.triangles.push_back(shifted);
    }
  }
  return out;
}

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
