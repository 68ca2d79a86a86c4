// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/holes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "packMesh/cat/levels_of_detail.h"
#include "packMesh/cat/tetrahedra.h"
#include "packMesh/cat/tetrahedralise.h"
#include "packMesh/parallel/periodic_images.h"

namespace packmesh {
namespace {

Vec3 circumcentre(const Tetrahedra& t, int index) {
  const Vec3& o = t.corner(index, 0);
  const Vec3 a = t.corner(index, 1) - o, b = t.corner(index, 2) - o, c = t.corner(index, 3) - o;
  const Vec3 bc = b.cross(c), ca = c.cross(a), ab = a.cross(b);
  return o + (a.squaredNorm() * bc + b.squaredNorm() * ca + c.squaredNorm() * ab) / (2.0 * a.dot(bc));
}

}  // namespace

/// The cells around a region.
struct Holes::Surroundings {
  std::vector<Body> cells;     ///< also as periodic images, except along axes of which the region has all
  Vec3 period = Vec3::Zero();  ///< along these axes [µm]
  double range = std::numeric_limits<double>::infinity();  ///< surfaces nearer than this are known [µm]
};

Holes::Holes(const Physics& physics, const Execution& execution) : physics_(physics), execution_(execution) {
  for (const int s : physics.shapesInUse()) {
    const Shape& shape = *physics.shapes[s];
    shapes_.try_emplace(s, SurfaceDistance(shape), MeshHierarchy(LevelsOfDetail(shape.mesh()).level(0.0)));
  }
}

Holes::Surroundings Holes::surroundingsOf(const Box& region, const std::vector<Body>& state) const {
  Surroundings around;
  const Vec3 whole = physics_.container->bounds().size();
  if (region.size() == whole) {
    around.cells = state;
    around.period = physics_.container->period();
    return around;
  }
  around.range = physics_.largest(&Shape::radius);
  Vec3 imaged = physics_.container->period();
  for (int k = 0; k < 3; ++k)
    if (region.size()[k] == whole[k]) around.period[k] = std::exchange(imaged[k], 0.0);
  for (const Body& cell : state) {
    const double reach = cell.scale * physics_.shapeOf(cell).radius() + around.range;
    forEachImage(cell.position, reach, region, imaged, [&](const ImageShift& shift) {
      Body image = cell;
      image.position += displacement(shift, imaged);
      if (region.squaredDistance(image.position) < reach * reach) around.cells.push_back(image);
    });
  }
  return around;
}

/// Radius of a sphere around `p` that contains no surface, up to the errors of the distance fields [µm].
double Holes::freeAround(const Vec3& p, const Surroundings& around) const {
  double free = around.range;
  for (const Species& species : physics_.species)
    if (const Wall* wall = physics_.wallOf(species))
      free = std::min(free, wall->distance(p).distance - wall->slack());
  for (const Body& cell : around.cells) {
    if (free <= 0.0) break;
    const SurfaceDistance& field = shapes_.at(cell.shape).first;
    const Vec3 offset = nearestImage(p - cell.position, around.period);
    const Vec3 q = cell.orientation.conjugate() * offset / cell.scale;
    if (cell.scale * field.lowerBound(q) > free) continue;
    const DistanceSample sample = field.sample(q);
    const double distance = sample.distance > 0.0 ? (field.foot(q, sample) - q).norm() : sample.distance;
    free = std::min(free, cell.scale * std::min(distance, std::abs(sample.distance)));
    if (sample.distance <= 0.0) return 0.0;
  }
  return free;
}

/// Of unconstrained Delaunay tetrahedra between coarse meshes: their circumspheres are as empty as those of
/// constrained ones, and their positions are checked later.
std::vector<Vec3> Holes::circumcentres(const Surroundings& around) const {
  TetrahedraInput input;
  for (const Body& cell : around.cells)
    input.objects.push_back({&shapes_.at(cell.shape).second, cell.pose().placement()});
  input.period = around.period;
  input.bounds = physics_.container->bounds();
  if (std::isfinite(around.range)) input.margin = around.range;
  input.kind = TetrahedraKind::delaunay;
  input.valid = true;  // only vertices are used
  input.explain = false;
  input.stop = execution_.interrupted;
  std::vector<Vec3> centres;
  try {
    const Tetrahedra tetrahedra = tetrahedralise(input);
    for (int t = 0; t < static_cast<int>(tetrahedra.tetrahedra.size()); ++t)
      centres.push_back(circumcentre(tetrahedra, t));
  } catch (const TetrahedraError&) {
  }
  return centres;
}

std::vector<Sphere> Holes::in(const Box& region, const std::vector<Body>& state, double least) const {
  std::vector<Sphere> found;
  const Surroundings around = surroundingsOf(region, state);
  if (around.cells.size() < 2) return found;
  for (const Vec3& center : circumcentres(around)) {
    if (!center.allFinite() || !region.contains(center)) continue;
    const double radius = freeAround(center, around);
    if (radius >= least) found.push_back({center, radius});
  }
  std::sort(found.begin(), found.end(), [](const Sphere& a, const Sphere& b) {
    if (a.radius != b.radius) return a.radius > b.radius;
    return std::lexicographical_compare(a.center.data(), a.center.data() + 3, b.center.data(),
                                        b.center.data() + 3);
  });
  const Vec3 period = physics_.container->period();
  std::vector<Sphere> holes;
  for (const Sphere& sphere : found) {
    const bool apart = std::all_of(holes.begin(), holes.end(), [&](const Sphere& hole) {
      return nearestImage(sphere.center - hole.center, period).norm() >= sphere.radius + hole.radius;
    });
    if (apart) holes.push_back(sphere);
  }
  return holes;
}

}  // namespace packmesh
