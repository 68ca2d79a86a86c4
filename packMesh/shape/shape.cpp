// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/shape/shape.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "packMesh/core/tolerances.h"
#include "packMesh/field/rough_distance.h"

namespace packmesh {
namespace {

/// Largest distance between samples on a cell's surface, as a fraction of its bounding radius and in µm: the
/// 642 vertices of HemoCell's red cell are just fine enough; its 66-vertex platelet is refined.
constexpr double sampleSpacingFraction = 0.3;
constexpr double largestSampleSpacing = 0.85;
/// Finest spacing, as a fraction of the bounding radius (about 10^5 samples). Blood cells do not need it; a
/// cell in the wrong unit of length would.
constexpr double finestSpacingFraction = 0.02;

/// Spacing of the distance grid of a general mesh, as a fraction of its bounding radius.
constexpr double gridSpacingFraction = 1.0 / 40.0;

/// The grid covers this many spacings around the mesh; as many inside its distances are exact.
constexpr double marginOfGrid = 8.0;

double halfThicknessOf(const std::variant<ProfileSurface, DistanceGrid>& field) {
  if (const auto* profile = std::get_if<ProfileSurface>(&field)) return profile->halfThickness();
  const DistanceGrid& grid = std::get<DistanceGrid>(field);
  const double deepest = -*std::min_element(grid.value.begin(), grid.value.end());
  return std::max(deepest, 0.5 * grid.spacing);  // thin parts fit between the nodes of a grid
}

double boundingRadius(const TriangleMesh& mesh) {
  double radius = 0.0;
  for (const Vec3& v : mesh.vertices) radius = std::max(radius, v.norm());
  return radius;
}

/// Spacing of the distance grid of a deformed cell, as a fraction of the edge of a cube of its volume:
/// coarser, since each cell has a grid of its own. The certificate finds what relaxation does not see.
constexpr double roughSpacingFraction = 1.0 / 13.0;

/// Rings that are tried for the convex bound of a deformed cell.
constexpr int fewRings = 5;

double reachOf(const Sphere& sphere) {
  return sphere.center.norm() + sphere.radius;
}

DistanceGrid gridOf(const MeshHierarchy& hierarchy, const Threads& threads) {
  const TriangleMesh& mesh = hierarchy.mesh();
  const double spacing = gridSpacingFraction * boundingRadius(mesh), margin = marginOfGrid * spacing;
  return sampleDistance(hierarchy, boundingBox(mesh).grownBy(margin), spacing, margin, threads);
}

std::variant<ProfileSurface, DistanceGrid> scaledBy(double factor,
                                                    std::variant<ProfileSurface, DistanceGrid> field) {
  if (const auto* profile = std::get_if<ProfileSurface>(&field)) return profile->scaledBy(factor);
  DistanceGrid& grid = std::get<DistanceGrid>(field);
  grid.origin *= factor;
  grid.spacing *= factor;
  for (float& value : grid.value) value *= float(factor);
  return field;
}

/// @param bound, box around the surface
FieldView viewOf(const std::variant<ProfileSurface, DistanceGrid>& field, const SupportBound& bound,
                 const Box& box) {
  FieldView view{};
  if (const auto* profile = std::get_if<ProfileSurface>(&field)) {
    view.onGrid = false;
    for (int k = 0; k < 6; ++k) view.p[k] = static_cast<float>(profile->p[k]);
    view.a = static_cast<float>(profile->a);
    view.c = static_cast<float>(profile->c);
    view.bend = static_cast<float>(profile->bendBeyondRim());
    view.curvature = static_cast<float>(profile->curvatureInside());
  } else {
    const auto& grid = std::get<DistanceGrid>(field);
    view.onGrid = true;
    view.value = grid.value.data();
    view.nodesPerLength = static_cast<float>(1.0 / grid.spacing);
    for (int k = 0; k < 3; ++k) {
      view.origin[k] = static_cast<float>(grid.origin[k]);
      view.nodes[k] = grid.nodes[k];
    }
  }
  view.ring = static_cast<float>(bound.ring);
  view.thickness = static_cast<float>(bound.semiAxes.maxCoeff());
  for (int k = 0; k < 3; ++k)
    view.extent[k] = static_cast<float>(std::max(std::abs(box.lo[k]), std::abs(box.hi[k])));
  return view;
}

}  // namespace

double ProfileSurface::slopeAtRim() const {
  double slope = 0.0;
  for (int k = 1; k < 6; ++k) slope += k * p[k];
  return slope;
}

double ProfileSurface::bendBeyondRim() const {
  const double rim2 = 1.0 / std::min(a, c);
  return std::min(0.0, -0.25 * (slopeAtRim() + rim2));
}

double ProfileSurface::curvatureInside() const {
  return std::max(1.0, -slopeAtRim() * std::max(a, c));
}

double ProfileSurface::halfThickness() const {
  constexpr int steps = 200;
  double highest = 0.0;
  for (int i = 0; i <= steps; ++i) {
    double height = 0.0;
    for (int k = 5; k >= 0; --k) height = height * i / steps + p[k];
    highest = std::max(highest, height);
  }
  return std::sqrt(highest / curvatureInside());
}

ProfileSurface ProfileSurface::scaledBy(double factor) const {
  ProfileSurface scaled = *this;
  for (double& coefficient : scaled.p) coefficient *= factor * factor;
  scaled.a /= factor * factor;
  scaled.c /= factor * factor;
  return scaled;
}

ProfileSurface ellipsoidProfile(double rx, double ry, double rz) {
  ProfileSurface surface;
  surface.p = {ry * ry, -ry * ry, 0.0, 0.0, 0.0, 0.0};
  surface.a = 1.0 / (rx * rx);
  surface.c = 1.0 / (rz * rz);
  return surface;
}

double Shape::sampleSpacing() const {
  return std::max(std::min(largestSampleSpacing, sampleSpacingFraction * radius_),
                  finestSpacingFraction * radius_);
}

Shape::Shape(MeshHierarchy&& hierarchy, Field field)
    : hierarchy_(std::move(hierarchy)),
      volume_(signedVolume(mesh())),
      radius_(boundingRadius(mesh())),
      halfThickness_(halfThicknessOf(field)),
      reach_(reachOf(boundingSphere(*hierarchy_, Placement()))),
      bound_(boundSupport(mesh())),
      contacts_(contactsWith(std::move(field))) {}

Shape::Shape(MeshHierarchy&& hierarchy, const Threads& threads)
    : Shape(std::move(hierarchy), Field(gridOf(hierarchy, threads))) {}

Shape::Shape(const TriangleMesh& mesh, const ProfileSurface& surface)
    : Shape(MeshHierarchy(mesh), Field(surface)) {}

Shape::Shape(const TriangleMesh& mesh, const Threads& threads) : Shape(MeshHierarchy(mesh), threads) {}

Shape::Shape(const Shape& other, double factor)
    : Shape(MeshHierarchy({scaledBy(factor, other.mesh().vertices), other.mesh().triangles}),
            scaledBy(factor, other.field())) {}

Shape::Shape(std::vector<Vec3> vertices, std::shared_ptr<const Shape> undeformed)
    : undeformed_(std::move(undeformed)),
      pending_(std::make_unique<Pending>()),
      halfThickness_(undeformed_->halfThickness()) {
  TriangleMesh mesh{std::move(vertices), undeformed_->mesh().triangles};
  volume_ = signedVolume(mesh);
  radius_ = boundingRadius(mesh);
  const Vec3 center = boundingBox(mesh).center();
  double radius = 0.0;
  for (const Vec3& v : mesh.vertices) radius = std::max(radius, (v - center).norm());
  reach_ = reachOf({center, radius}) + tolerance::culling;
  bound_ = boundSupport(mesh, fewRings);
  pending_->vertices = std::move(mesh.vertices);
}

/// Pre: the mesh and its bound are there
Shape::Contacts Shape::contactsWith(Field field) const {
  Contacts made{sampleSurface(mesh(), sampleSpacing()), sampleCoarsely(mesh()), std::move(field), {}};
  made.views = {viewOf(made.samples), viewOf(made.coarseSamples),
                viewOf(made.field, bound_, boundingBox(mesh()))};
  return made;
}

const MeshHierarchy& Shape::madeHierarchy() const {
  std::call_once(pending_->hierarchy, [&] {
    hierarchy_.emplace(std::exchange(pending_->vertices, {}), undeformed_->hierarchy());
  });
  return *hierarchy_;
}

const Shape::Contacts& Shape::madeContacts() const {
  std::call_once(pending_->contacts, [&] {
    const double spacing = roughSpacingFraction * std::cbrt(volume_);
    contacts_.emplace(contactsWith(sampleRoughly(mesh(), boundingBox(mesh()).grownBy(spacing), spacing)));
  });
  return *contacts_;
}

}  // namespace packmesh
