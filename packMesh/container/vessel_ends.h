// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Opening, continuing and joining the ends of a vessel mesh. Internal to packMesh/container.
#pragma once

#include <array>
#include <vector>

#include "packMesh/core/vector.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// Whether the mesh has a cap for makeVessel at both ends of the axis.
bool hasFlatEnds(const TriangleMesh& surface, int axis);

/// A vessel mesh taken apart: the wall, and the flat caps at both ends of an axis.
struct OpenedVessel {
  TriangleMesh mesh;                          ///< all vertices; the triangles of the wall only
  std::array<std::vector<Triangle>, 2> caps;  ///< at the low and the high end
  int axis;
  double lo, hi;  ///< where the caps are [µm]

  /// The wall continued straight until the planes `newLo` and `newHi`; an end that lies further out already
  /// stays.
  TriangleMesh wallUntil(double newLo, double newHi) const { return continued(newLo, newHi, false); }
  /// The same, closed by caps.
  TriangleMesh closedUntil(double newLo, double newHi) const { return continued(newLo, newHi, true); }

 private:
  TriangleMesh continued(double newLo, double newHi, bool closed) const;
};

/// Takes the caps off. @throws MeshError when an end has none
OpenedVessel openVessel(const TriangleMesh& surface, int axis);

/// Where `mesh` crosses the plane coordinate[axis] = x: pairs of end points of segments; neighbouring
/// segments of a closed mesh share theirs to the bit.
std::vector<std::array<Eigen::Vector2d, 2>> outlineAt(const TriangleMesh& mesh, int axis, double x);

/// @throws MeshError unless the outlines of `closed` at lo and hi are the same, within a thousandth of their
/// size.
void requireSameOutlines(const TriangleMesh& closed, int axis, double lo, double hi);

/// `wall` with as much of its images `period` before and after along `axis` as lies within `reach` of [lo,
/// hi].
TriangleMesh withImages(const TriangleMesh& wall, int axis, double lo, double hi, double reach);

}  // namespace packmesh
