// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Opening, continuing and joining the ends of a vessel mesh. Internal to packMesh/container.
#pragma once

#include <array>
#include <vector>

#include "packMesh/core/vector.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// True if the mesh has a cap (see makeVessel) at both ends of the axis.
bool hasFlatEnds(const TriangleMesh& surface, int axis);

/// A vessel mesh separated into the wall and the flat caps at both ends of an axis.
struct OpenedVessel {
  TriangleMesh mesh;                          ///< all vertices, but only the triangles of the wall
  std::array<std::vector<Triangle>, 2> caps;  ///< at the low and the high end
  int axis;
  double lo, hi;  ///< positions of the caps [µm]

  /// Of the caps at the low (0) or the high end (1) [µm²].
  double capArea(int end) const;

  /// The wall, continued straight to the planes `newLo` and `newHi`; an end that already lies further out is
  /// unchanged.
  TriangleMesh wallUntil(double newLo, double newHi) const { return continued(newLo, newHi, false); }
  /// The same, closed by caps.
  TriangleMesh closedUntil(double newLo, double newHi) const { return continued(newLo, newHi, true); }

 private:
  TriangleMesh continued(double newLo, double newHi, bool closed) const;
};

/// Removes the caps. @throws MeshError if an end has none
OpenedVessel openVessel(const TriangleMesh& surface, int axis);

/// Intersection of `mesh` with the plane coordinate[axis] = x: pairs of end points of segments; adjacent
/// segments of a closed mesh share end points to the bit.
std::vector<std::array<Eigen::Vector2d, 2>> outlineAt(const TriangleMesh& mesh, int axis, double x);

/// @throws MeshError unless the outlines of `closed` at lo and hi agree to a thousandth of their size.
void requireSameOutlines(const TriangleMesh& closed, int axis, double lo, double hi);

/// `wall` with the parts of its images at distance `period` before and after it along `axis` that lie within
/// `reach` of [lo, hi] [µm].
TriangleMesh withImages(const TriangleMesh& wall, int axis, double lo, double hi, double reach);

}  // namespace packmesh
