// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Shape of a species: a template mesh, and what packing needs of it: points on its surface, a convex
/// body around it.
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <variant>
#include <vector>

#include "packMesh/field/distance_grid.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/shape/field_view.h"

namespace packmesh {

/// Minkowski sum of a disc (radius `ring`, in the body's x-z plane) and an axis-aligned ellipsoid: exact for
/// ellipsoids, within 1 % for red cells, valid for every shape.
struct SupportBound {
  double ring = 0.0;             ///< radius of the disc [µm]
  Vec3 semiAxes = Vec3::Ones();  ///< [µm]

  /// Largest n·x over the body, for a unit vector n in the body frame [µm].
  double support(const Vec3& n) const {
    return ring * std::sqrt(n.x() * n.x() + n.z() * n.z()) + semiAxes.cwiseProduct(n).norm();
  }
};

/// The tightest bound of this kind found for the vertices of `mesh`. Post: contains every vertex.
/// @param rings number of radii of the disc that are tried
SupportBound boundSupport(const TriangleMesh& mesh, int rings = 40);

/// Sample points of a surface in the body frame [µm], grouped into spatially compact clusters of `width`, as
/// structure of arrays. A cluster with fewer points repeats them equally often (up to one): if there are
/// several clusters, no point occurs more than twice.
struct SamplePoints {
  static constexpr int width = 16;

  int clusters = 0;
  std::vector<float> x, y, z;                            ///< clusters * width entries
  std::vector<float> centerX, centerY, centerZ, radius;  ///< bounding spheres, padded to a multiple of width
};

/// Samples the surface of `mesh` by its vertices and, where edges are longer than `spacing` [µm], by points
/// on its triangles, so that no point of the surface is further than about `spacing` from a sample.
SamplePoints sampleSurface(const TriangleMesh& mesh, double spacing);

/// About every fourth vertex, evenly spread: sufficient to separate cells that overlap deeply.
SamplePoints sampleCoarsely(const TriangleMesh& mesh);

/// Up to `count` vertices, each the farthest one from those before it; the first is farthest from the origin.
std::vector<Vec3> spreadPoints(const TriangleMesh& mesh, int count);

/// A smooth closed surface in closed form: y² = P(s) with s = a·x² + c·z² in [0, 1] (body frame, µm), where P
/// is a polynomial. Includes red cells (symmetry axis y), spheres and ellipsoids.
struct ProfileSurface {
  std::array<double, 6> p{};  ///< P(s) = p[0] + p[1] s + ... + p[5] s^5 [µm²]
  double a = 1.0, c = 1.0;    ///< [1/µm²]

  double slopeAtRim() const;  ///< P'(1) [µm²]

  /// Second-order coefficient with which P is continued beyond the rim, P(s) = P'(1) (s - 1) + bend (s - 1)²:
  /// y² - P(s) then has second derivative 2 across the rim, as the distance formula assumes, and remains
  /// convex [µm²].
  double bendBeyondRim() const;

  /// For an ellipsoid, (r_y / r)² with r the smallest semi-axis: half the largest second derivative of y² -
  /// P(s). 1 if y is the shortest axis, as for red cells.
  double curvatureInside() const;

  double halfThickness() const;  ///< half the largest thickness [µm]

  ProfileSurface scaledBy(double factor) const;
};

/// Ellipsoid with semi-axes [µm] as a ProfileSurface.
ProfileSurface ellipsoidProfile(double rx, double ry, double rz);

/// Shape of one species. Immutable; shared by all cells of the species.
///
/// A deformed cell has a shape of its own. Its parts are made when they are first needed, by any thread:
/// ranks make only those of the cells that they examine or move.
class Shape {
 public:
  /// A mesh that approximates a surface in closed form.
  Shape(const TriangleMesh& mesh, const ProfileSurface& surface);
  /// Any closed, outward-oriented mesh (see repairClosed); its distance is sampled on a grid.
  /// @param threads share the sampling
  explicit Shape(const TriangleMesh& mesh, const Threads& threads = {});
  /// A template of another size: no distance is sampled. Pre: `other` is not a deformed form
  Shape(const Shape& other, double factor);
  /// A deformed form of another shape.
  /// @param vertices in the order of the other mesh, around the same origin and in about the same orientation
  /// [µm]. Pre: with its triangles they are a closed, outward-oriented surface
  Shape(std::vector<Vec3> vertices, std::shared_ptr<const Shape> undeformed);

  const TriangleMesh& mesh() const { return pending_ ? *pending_->mesh : hierarchy_->mesh(); }
  const MeshHierarchy& hierarchy() const { return pending_ ? madeHierarchy() : *hierarchy_; }
  /// Frees the hierarchy of a deformed cell until it is needed again: it is five times as large as the
  /// vertices. Pre: no other thread uses the shape, and there is no reference to the hierarchy
  void forgetHierarchy() const;
  /// Of a deformed cell: the template; otherwise nullptr.
  const std::shared_ptr<const Shape>& undeformed() const { return undeformed_; }
  double volume() const { return volume_; }  ///< volume of the mesh [µm³]
  double radius() const {
    return radius_;
  }  ///< radius of the smallest enclosing sphere around the body origin [µm]
  const Sphere& sphere() const { return sphere_; }  ///< around all vertices, in the body frame [µm]
  /// Radius around the body origin that contains the bounding sphere of the mesh [µm].
  double reach() const { return reach_; }
  /// Largest depth of a point inside [µm]; of a deformed cell: that of its template.
  double halfThickness() const { return halfThickness_; }
  const SupportBound& bound() const { return bound_; }
  double sampleSpacing() const;  ///< approximate largest distance of a surface point from a sample [µm]
  const SamplePoints& samples() const { return contacts().samples; }
  const ContactViews& views() const { return contacts().views; }
  const std::variant<ProfileSurface, DistanceGrid>& field() const { return contacts().field; }

 private:
  using Field = std::variant<ProfileSurface, DistanceGrid>;
  /// What finds contacts.
  struct Contacts {
    SamplePoints samples, coarseSamples;
    Field field;
    ContactViews views;  ///< of these
  };
  /// Of a deformed cell: what is made later, and of what.
  struct Pending {
    std::shared_ptr<const TriangleMesh> mesh;
    std::optional<std::once_flag> hierarchy;
    std::once_flag contacts;
  };

  Shape(MeshHierarchy&& hierarchy, const Threads& threads);
  Shape(MeshHierarchy&& hierarchy, Field field);
  Contacts contactsWith(Field field) const;
  const Contacts& contacts() const { return pending_ ? madeContacts() : *contacts_; }
  const MeshHierarchy& madeHierarchy() const;
  const Contacts& madeContacts() const;

  std::shared_ptr<const Shape> undeformed_;
  std::unique_ptr<Pending> pending_;
  mutable std::optional<MeshHierarchy> hierarchy_;
  double volume_, radius_, halfThickness_, reach_;
  Sphere sphere_;
  SupportBound bound_;
  mutable std::optional<Contacts> contacts_;
};

}  // namespace packmesh
