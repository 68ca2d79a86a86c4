// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/escape/holes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "packMesh/growth/levels_of_detail.h"
#include "packMesh/growth/resampling.h"
#include "packMesh/growth/tetrahedra.h"
#include "packMesh/growth/tetrahedralise.h"
#include "packMesh/shape/surface_distance.h"

namespace packmesh {
namespace {

/// Distances from a point to the surrounding surfaces.
class FreeSpace {
 public:
  FreeSpace(const GrowthScene& scene, const std::vector<Body>& state) : scene_(scene), state_(state) {
    for (const Shape* shape : scene.shapes) fields_.emplace_back(*shape);
    for (const Body& cell : state) inverse_.push_back(cell.orientation.conjugate());
  }

  /// Radius of a sphere around `p` that contains no surface, up to the errors of the distance fields [µm].
  double around(const Vec3& p) const {
    double free = std::numeric_limits<double>::infinity();
    for (const Wall* wall : scene_.walls)
      if (wall) free = std::min(free, wall->distance(p).distance - wall->slack());
    const Vec3 period = scene_.container->period();
    for (std::size_t i = 0; i < state_.size() && free > 0.0; ++i) {
      const Body& pose = state_[i];
      const SurfaceDistance& field = fields_[state_[i].species];
      Vec3 offset = p - pose.position;
      for (int k = 0; k < 3; ++k)
        if (period[k] > 0.0) offset[k] -= period[k] * std::round(offset[k] / period[k]);
      const Vec3 q = inverse_[i] * offset / pose.scale;
      if (pose.scale * field.lowerBound(q) > free) continue;
      const DistanceSample sample = field.sample(q);
      const double distance = sample.distance > 0.0 ? (field.foot(q, sample) - q).norm() : sample.distance;
      free = std::min(free, pose.scale * std::min(distance, std::abs(sample.distance)));
      if (sample.distance <= 0.0) return 0.0;
    }
    return free;
  }

 private:
  const GrowthScene& scene_;
  const std::vector<Body>& state_;
  std::vector<SurfaceDistance> fields_;
  std::vector<Quaternion> inverse_;
};

Vec3 circumcentre(const Tetrahedra& t, int index) {
  const Vec3& o = t.corner(index, 0);
  const Vec3 a = t.corner(index, 1) - o, b = t.corner(index, 2) - o, c = t.corner(index, 3) - o;
  const Vec3 bc = b.cross(c), ca = c.cross(a), ab = a.cross(b);
  return o + (a.squaredNorm() * bc + b.squaredNorm() * ca + c.squaredNorm() * ab) / (2.0 * a.dot(bc));
}

/// Unconstrained Delaunay tetrahedra between coarse meshes: their circumspheres are as empty as those of
/// constrained ones, and their positions are checked later.
Tetrahedra tetrahedraBetween(const GrowthScene& scene, const std::vector<Body>& state) {
  std::vector<std::unique_ptr<MeshHierarchy>> coarse;
  for (const Shape* shape : scene.shapes)
    coarse.push_back(std::make_unique<MeshHierarchy>(LevelsOfDetail(shape->mesh()).level(0.0)));
  TetrahedraInput input;
  for (const Body& cell : state)
    input.objects.push_back({coarse[cell.species].get(), cell.pose().placement()});
  input.period = scene.container->period();
  input.bounds = scene.container->bounds();
  input.kind = TetrahedraKind::delaunay;
  input.kept = TetrahedraKept::joining;
  input.valid = true;  // only vertices are used
  return tetrahedralise(input);
}

}  // namespace

std::vector<Sphere> findHoles(const GrowthScene& scene, const std::vector<Body>& state, double least) {
  std::vector<Sphere> found;
  if (state.size() < 2) return found;
  const Tetrahedra tetrahedra = tetrahedraBetween(scene, state);
  const FreeSpace space(scene, state);
  const Box bounds = scene.container->bounds();
  for (int t = 0; t < static_cast<int>(tetrahedra.tetrahedra.size()); ++t) {
    const Vec3 center = circumcentre(tetrahedra, t);
    if (!center.allFinite() || !bounds.contains(center)) continue;
    const double radius = space.around(center);
    if (radius >= least) found.push_back({center, radius});
  }
  std::sort(found.begin(), found.end(), [](const Sphere& a, const Sphere& b) {
    if (a.radius != b.radius) return a.radius > b.radius;
    return std::lexicographical_compare(a.center.data(), a.center.data() + 3, b.center.data(),
                                        b.center.data() + 3);
  });
  const Vec3 period = scene.container->period();
  std::vector<Sphere> holes;
  for (const Sphere& sphere : found) {
    const bool apart = std::all_of(holes.begin(), holes.end(), [&](const Sphere& hole) {
      Vec3 between = sphere.center - hole.center;
      for (int k = 0; k < 3; ++k)
        if (period[k] > 0.0) between[k] -= period[k] * std::round(between[k] / period[k]);
      return between.norm() >= sphere.radius + hole.radius;
    });
    if (apart) holes.push_back(sphere);
  }
  return holes;
}

}  // namespace packmesh
