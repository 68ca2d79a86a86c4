// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/obstacles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "packMesh/container/region.h"
#include "packMesh/container/vessel.h"
#include "packMesh/core/error.h"
#include "packMesh/field/distance_grid.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/parallel/blocks.h"

namespace packmesh {
namespace {

/// The distance grid extends this far from the body [µm]; further away its bounding box is used instead.
constexpr double gridMargin = 2.0;

/// The part of a convex polygon with axis·p >= bound (sign +1) or <= bound (sign -1).
std::vector<Vec3> clipped(const std::vector<Vec3>& polygon, int axis, double bound, double sign) {
  std::vector<Vec3> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3& a = polygon[i];
    const Vec3& b = polygon[(i + 1) % polygon.size()];
    const double da = sign * (a[axis] - bound), db = sign * (b[axis] - bound);
    if (da >= 0) kept.push_back(a);
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
      Vec3 crossing = a + (b - a) * (da / (da - db));
      crossing[axis] = bound;
      kept.push_back(crossing);
    }
  }
  return kept;
}

/// Integral of z - zero over the projection of a convex polygon onto the x-y plane, signed by its
/// orientation.
double columnIntegral(const std::vector<Vec3>& polygon, double zero) {
  double sum = 0.0;
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    const Vec3 u = polygon[i - 1] - polygon[0], v = polygon[i] - polygon[0];
    const double area = 0.5 * (u.x() * v.y() - u.y() * v.x());
    sum += area * ((polygon[0].z() + polygon[i - 1].z() + polygon[i].z()) / 3.0 - zero);
  }
  return sum;
}

/// One obstacle with its search structures.
struct Body {
  explicit Body(const Obstacle& obstacle)
      : name(obstacle.name),
        box(boundingBox(obstacle.surface)),
        spacing(std::max(0.25, std::cbrt(box.grownBy(gridMargin).volume() / 1e7))),
        hierarchy(obstacle.surface),
        grid(sampleDistance(hierarchy, box.grownBy(gridMargin), spacing, gridMargin)) {}

  WallDistance distance(const Vec3& p) const {
    const double toBox = std::sqrt(box.squaredDistance(p));
    if (toBox >= gridMargin) {
      const Vec3 nearest = p.cwiseMax(box.lo).cwiseMin(box.hi);
      return {toBox, (p - nearest) / toBox};
    }
    const DistanceSample at = grid.sample(p);
    const double norm = at.gradient.norm();
    return {at.distance, norm > 0 ? Vec3(at.gradient / norm) : Vec3::UnitX()};
  }

  std::string name;
  Box box;
  double spacing;
  MeshHierarchy hierarchy;
  DistanceGrid grid;
};

const char* violationOf(MeshRelation relation) {
  switch (relation) {
    case MeshRelation::firstInside:
      return "is inside an obstacle";
    case MeshRelation::secondInside:
      return "encloses an obstacle";
    default:
      return "meets an obstacle";
  }
}

class ObstacleWall : public Wall {
 public:
  ObstacleWall(const Wall* outer, const Vec3& period, std::vector<Obstacle> obstacles)
      : outer_(outer), shifts_(periodicShifts(period)) {
    for (Obstacle& obstacle : obstacles) bodies_.emplace_back(std::move(obstacle));
    for (const Body& body : bodies_) slack_ = std::max(slack_, body.grid.interpolationError());
    if (outer_) slack_ = std::max(slack_, outer_->slack());
  }

  WallDistance distance(const Vec3& p) const override {
    return nearestOf(outer_ ? outer_->distance(p) : endless, p);
  }

  WallDistance distanceToSides(const Vec3& p, const std::array<bool, 3>& ends) const override {
    return nearestOf(outer_ ? outer_->distanceToSides(p, ends) : endless, p);
  }

  double slack() const override { return slack_; }

  WallVerdict examine(const PlacedHierarchy& cell, double gapOfInterest) const override {
    WallVerdict verdict;
    if (outer_) verdict = outer_->examine(cell, gapOfInterest);
    if (verdict.violation) return verdict;
    Box box;
    for (std::size_t i = 0; i < cell.vertexCount(); ++i) box.add(cell.vertex(i));
    for (const Body& body : bodies_) {
      for (const Vec3& shift : shifts_) {
        const double limit = std::min(verdict.gap, gapOfInterest);
        if (!box.grownBy(limit).meets({body.box.lo + shift, body.box.hi + shift})) continue;
        const MeshPairResult result =
            relate(cell.hierarchy, cell.placement, body.hierarchy, {Mat3::Identity(), shift}, limit);
        if (result.relation != MeshRelation::apart) return {violationOf(result.relation)};
        verdict.gap = std::min(verdict.gap, result.gap);
      }
    }
    return verdict;
  }

  const std::vector<Body>& bodies() const { return bodies_; }
  const std::vector<Vec3>& shifts() const { return shifts_; }

 private:
  static inline const WallDistance endless{std::numeric_limits<double>::infinity(), Vec3::UnitX()};

  /// The nearer of a wall and the obstacles.
  WallDistance nearestOf(WallDistance nearest, const Vec3& p) const {
    for (const Body& body : bodies_) {
      for (const Vec3& shift : shifts_) {
        const Vec3 q = p - shift;
        const double toBox = std::sqrt(body.box.squaredDistance(q));
        if (toBox > 0.0 && toBox >= nearest.distance) continue;
        const WallDistance d = body.distance(q);
        if (d.distance < nearest.distance) nearest = d;
      }
    }
    return nearest;
  }

  const Wall* outer_;
  std::vector<Body> bodies_;
  std::vector<Vec3> shifts_;  ///< translations to the periodic images, zero included
  double slack_ = 0.0;
};

/// The volume that bodies leave of a lumen: cubes crossed by a surface are halved, each with a list of the
/// surfaces near it.
class VolumeBeside {
 public:
  VolumeBeside(const Container& outer, const std::vector<Body>& bodies, const std::vector<Vec3>& shifts)
      : outer_(outer) {
    for (const Body& body : bodies) {
      solids_.push_back(makeVessel(body.hierarchy.mesh(), std::nullopt, body.spacing));
      for (const Vec3& shift : shifts) images_.push_back({solids_.back().get(), shift});
    }
  }

  /// With all bodies, or with none.
  double operator()(bool withBodies) const {
    return in(outer_.bounds(), outer_.wall() != nullptr, withBodies ? images_ : std::vector<Image>(),
              deepest);
  }

 private:
  /// Maximum number of halvings: accurate to about 1e-4 of the lumen.
  static constexpr int deepest = 8;

  struct Image {
    const Container* solid;
    Vec3 shift;
  };

  double in(const Box& box, bool wallIsNear, const std::vector<Image>& images, int depth) const {
    const Vec3 center = box.center();
    const double reach = 0.5 * box.size().norm() + (outer_.wall() ? outer_.wall()->slack() : 0.0);
    WallDistance nearest{std::numeric_limits<double>::infinity(), Vec3::UnitX()};
    if (wallIsNear) nearest = outer_.wall()->distance(center);
    const bool wallStaysNear = nearest.distance <= reach;
    std::vector<Image> near;
    for (const Image& image : images) {
      const Vec3 p = center - image.shift;
      if (std::sqrt(image.solid->bounds().squaredDistance(p)) > reach) continue;
      const WallDistance d = image.solid->wall()->distance(p);
      if (d.distance < -reach) continue;
      near.push_back(image);
      if (-d.distance < nearest.distance) nearest = {-d.distance, -d.gradient};
    }
    return volumeByHalving(box, nearest, reach, depth, [&](const Box& part, int further) {
      return in(part, wallStaysNear, near, further);
    });
  }

  const Container& outer_;
  std::vector<std::shared_ptr<const Container>> solids_;
  std::vector<Image> images_;
};

/// True if a triangle of one body lies entirely in another body that is moved by `shift`.
bool liesIn(const TriangleMesh& mesh, const Triangle& t, const MeshHierarchy& other, const Vec3& shift) {
  const Placement moved{Mat3::Identity(), shift};
  for (const int v : t)
    if (!isInside(mesh.vertices[v], other, moved)) return false;
  const MeshHierarchy one({{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}, {{0, 1, 2}}});
  return surfaceGap(one, Placement(), other, moved, std::numeric_limits<double>::min()) > 0.0;
}

class ContainerWithObstacles : public Container {
 public:
  ContainerWithObstacles(std::shared_ptr<const Container> outer, std::vector<Obstacle> obstacles)
      : outer_(std::move(outer)), wall_(outer_->wall(), outer_->period(), std::move(obstacles)) {
    volume_ = areApart() && areCutByBounds() ? volumeBesideApart() : volumeBesideUnion();
    if (!(volume_ > 0)) throw InputError("the obstacles fill the whole lumen");
  }

  Box bounds() const override { return outer_->bounds(); }
  Vec3 period() const override { return outer_->period(); }
  double volume() const override { return volume_; }
  const Wall* wall() const override { return &wall_; }

  std::string describe() const override {
    const std::size_t n = wall_.bodies().size();
    return outer_->describe() + " with " + std::to_string(n) + (n == 1 ? " obstacle" : " obstacles");
  }

  TriangleMesh surface() const override {
    TriangleMesh all = outer_->surface();
    const MeshHierarchy outer(all);
    removeHidden(all, nullptr);
    for (const Body& body : wall_.bodies()) {
      TriangleMesh inner = body.hierarchy.mesh();
      removeHidden(inner, &body);
      removeOutside(inner, outer);
      flip(inner);
      const int first = int(all.vertices.size());
      all.vertices.insert(all.vertices.end(), inner.vertices.begin(), inner.vertices.end());
      for (Triangle t : inner.triangles) all.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
    return all;
  }

 private:
  /// Volume that a body, with its periodic images, occupies within the bounds of the lumen.
  double occupied(const Body& body) const {
    const Box bounds = outer_->bounds();
    double volume = 0.0;
    for (const Vec3& shift : wall_.shifts())
      volume += volumeInside(body.hierarchy.mesh(), {bounds.lo - shift, bounds.hi - shift});
    return volume;
  }

  [[noreturn]] static void refuseOutside(const Body& body) {
    throw InputError(body.name + ": the obstacle lies outside the lumen");
  }

  double volumeBesideApart() const {
    double volume = outer_->volume();
    for (const Body& body : wall_.bodies()) {
      const double taken = occupied(body);
      if (!(taken > 0)) refuseOutside(body);
      volume -= taken;
    }
    return volume;
  }

  double volumeBesideUnion() const {
    const Container& outer = *outer_;
    for (const Body& body : wall_.bodies())
      if (!(occupied(body) > 0) || !(reachesIn(body) || takesVolume(body))) refuseOutside(body);
    const VolumeBeside beside(outer, wall_.bodies(), wall_.shifts());
    // The volume of a vessel can differ from that of its distance field: measure only what the obstacles
    // occupy.
    return outer.wall() && !outer.wall()->closedForm() ? outer.volume() - (beside(false) - beside(true))
                                                       : beside(true);
  }

  bool takesVolume(const Body& body) const {
    const std::shared_ptr<const Container> solid =
        makeVessel(body.hierarchy.mesh(), std::nullopt, body.spacing);
    return volumeInLumen(BodyRegion(solid, outer_->bounds(), outer_->period()), *outer_) > 0.0;
  }

  /// True if a vertex of the body is in the lumen, so that part of the body is.
  bool reachesIn(const Body& body) const {
    const std::vector<Vec3>& vertices = body.hierarchy.mesh().vertices;
    return std::any_of(vertices.begin(), vertices.end(), [&](const Vec3& v) {
      return outer_->bounds().contains(v) && (!outer_->wall() || outer_->wall()->distance(v).distance > 0.0);
    });
  }

  bool areApart() const {
    const std::vector<Body>& all = wall_.bodies();
    for (std::size_t i = 0; i < all.size(); ++i)
      for (std::size_t j = i; j < all.size(); ++j)
        for (const Vec3& shift : wall_.shifts())
          if (!(i == j && shift.isZero()) &&
              relate(all[i].hierarchy, Placement{}, all[j].hierarchy, {Mat3::Identity(), shift}).relation !=
                  MeshRelation::apart)
            return false;
    return true;
  }

  /// True if bodies are cut only by the bounds of the lumen: it is a box, or they are entirely inside.
  bool areCutByBounds() const {
    constexpr double rounding = 1e-12;
    if (!outer_->wall() || std::abs(outer_->volume() / outer_->bounds().volume() - 1.0) < rounding)
      return true;
    return std::none_of(wall_.bodies().begin(), wall_.bodies().end(), [&](const Body& body) {
      return outer_->wall()->examine({body.hierarchy, Placement()}, 0.0).violation.has_value();
    });
  }

  /// Removes the triangles that lie entirely in a body other than `own`, or in an image of any body.
  void removeHidden(TriangleMesh& mesh, const Body* own) const {
    const std::vector<Triangle> given = std::move(mesh.triangles);
    mesh.triangles.clear();
    for (const Triangle& t : given) {
      Box box;
      for (const int v : t) box.add(mesh.vertices[v]);
      bool hidden = false;
      for (const Body& body : wall_.bodies())
        for (const Vec3& shift : wall_.shifts())
          hidden = hidden || (!(&body == own && shift.isZero()) &&
                              box.meets({body.box.lo + shift, body.box.hi + shift}) &&
                              liesIn(mesh, t, body.hierarchy, shift));
      if (!hidden) mesh.triangles.push_back(t);
    }
  }

  /// Removes the triangles of a body that lie entirely outside the lumen in all images.
  void removeOutside(TriangleMesh& mesh, const MeshHierarchy& outer) const {
    const std::vector<Triangle> given = std::move(mesh.triangles);
    mesh.triangles.clear();
    for (const Triangle& t : given) {
      const MeshHierarchy one({{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}, {{0, 1, 2}}});
      bool within = false;
      for (const Vec3& shift : wall_.shifts()) {
        const Placement moved{Mat3::Identity(), shift};
        within = within || isInside(mesh.vertices[t[0]], outer, moved) ||
                 surfaceGap(one, Placement(), outer, moved, std::numeric_limits<double>::min()) == 0.0;
      }
      if (within) mesh.triangles.push_back(t);
    }
  }

  std::shared_ptr<const Container> outer_;
  ObstacleWall wall_;
  double volume_ = 0.0;
};

}  // namespace

std::shared_ptr<const Container> subtractObstacles(std::shared_ptr<const Container> outer,
                                                   std::vector<Obstacle> obstacles) {
  return std::make_shared<ContainerWithObstacles>(std::move(outer), std::move(obstacles));
}

double volumeInside(const TriangleMesh& mesh, const Box& box) {
  // Columns along z: each triangle contributes the height of the column below it, clamped to the box.
  double volume = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::vector<Vec3> polygon = {mesh.corner(int(t), 0), mesh.corner(int(t), 1), mesh.corner(int(t), 2)};
    for (int axis = 0; axis < 2; ++axis) {
      polygon = clipped(polygon, axis, box.lo[axis], 1.0);
      polygon = clipped(polygon, axis, box.hi[axis], -1.0);
    }
    const std::vector<Vec3> aboveLow = clipped(polygon, 2, box.lo.z(), 1.0);
    volume += columnIntegral(clipped(aboveLow, 2, box.hi.z(), -1.0), box.lo.z());
    std::vector<Vec3> top = clipped(aboveLow, 2, box.hi.z(), 1.0);
    for (Vec3& p : top) p.z() = box.hi.z();
    volume += columnIntegral(top, box.lo.z());
  }
  return volume;
}

}  // namespace packmesh
