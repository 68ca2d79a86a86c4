// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Shape of a species: a template mesh with precomputed data for packing.
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <variant>
#include <vector>

#include "packMesh/field/distance_grid.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/shape/field_view.h"
#include "packMesh/shape/sample_points.h"
#include "packMesh/shape/support_bound.h"

namespace packmesh {

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

  const TriangleMesh& mesh() const { return hierarchy().mesh(); }
  const MeshHierarchy& hierarchy() const { return pending_ ? madeHierarchy() : *hierarchy_; }
  /// Of a deformed cell: the template; otherwise nullptr.
  const std::shared_ptr<const Shape>& undeformed() const { return undeformed_; }
  double volume() const { return volume_; }  ///< volume of the mesh [µm³]
  double radius() const {
    return radius_;
  }  ///< radius of the smallest enclosing sphere around the body origin [µm]
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
    std::vector<Vec3> vertices;  ///< until there is a hierarchy
    std::once_flag hierarchy, contacts;
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
  SupportBound bound_;
  mutable std::optional<Contacts> contacts_;
};

}  // namespace packmesh
