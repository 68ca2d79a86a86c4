// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What is packed: a template mesh with everything that makes packing it fast.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <variant>

#include "packMesh/field/distance_grid.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/shape/sample_points.h"
#include "packMesh/shape/support_bound.h"

namespace packmesh {

/// A smooth closed surface in closed form: y² = P(s) with s = a·x² + c·z² in [0, 1] (body frame, µm), P a
/// polynomial. Red cells (thin axis y), spheres and all ellipsoids are of this kind.
struct ProfileSurface {
  std::array<double, 6> p{};  ///< P(s) = p[0] + p[1] s + ... + p[5] s^5 [µm²]
  double a = 1.0, c = 1.0;    ///< [1/µm²]

  double slopeAtRim() const;  ///< P'(1) [µm²]

  /// Curvature with which P is continued beyond the rim, P(s) = P'(1) (s - 1) + bend (s - 1)²: y² - P(s) then
  /// has second derivative 2 across the rim, as the formula of the distance assumes, and stays convex [µm²].
  double bendBeyondRim() const;

  /// Of an ellipsoid (r_y / r)², r its smallest semi-axis: half the largest second derivative of y² - P(s).
  /// 1 where y is the thinnest axis, as of a red cell.
  double curvatureInside() const;

  double halfThickness() const;  ///< that of the thickest part [µm]
};

/// Ellipsoid with semi-axes [µm] as a ProfileSurface.
ProfileSurface ellipsoidProfile(double rx, double ry, double rz);

/// One template. Immutable; shared by all cells of its species.
class Shape {
 public:
  /// A mesh that approximates a surface in closed form.
  Shape(const TriangleMesh& mesh, const ProfileSurface& surface);
  /// Any closed, outward-oriented mesh (see repairClosed): its distance is sampled on a grid.
  explicit Shape(const TriangleMesh& mesh);

  const TriangleMesh& mesh() const { return hierarchy_.mesh(); }
  const MeshHierarchy& hierarchy() const { return hierarchy_; }
  double volume() const { return volume_; }  ///< of the mesh [µm³]
  double radius() const { return radius_; }  ///< of the smallest sphere around the body origin [µm]
  double halfThickness() const { return halfThickness_; }  ///< depth of the points deepest inside [µm]
  const SupportBound& bound() const { return bound_; }
  double sampleSpacing() const;  ///< no point of the surface is much further than this from a sample [µm]
  const SamplePoints& samples() const { return samples_; }
  const SamplePoints& coarseSamples() const { return coarseSamples_; }
  const std::variant<ProfileSurface, DistanceGrid>& field() const { return field_; }

 private:
  Shape(const TriangleMesh& mesh, std::variant<ProfileSurface, DistanceGrid> field);

  MeshHierarchy hierarchy_;
  double volume_, radius_, halfThickness_;
  SupportBound bound_;
  SamplePoints samples_, coarseSamples_;
  std::variant<ProfileSurface, DistanceGrid> field_;
};

}  // namespace packmesh
