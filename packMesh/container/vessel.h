// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Vessels: any watertight surface as a container.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "packMesh/container/container.h"
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
std::vector<std::array<Vec2, 2>> outlineAt(const TriangleMesh& mesh, int axis, double x);

/// @throws MeshError unless the outlines of `closed` at lo and hi agree to a thousandth of their size.
void requireSameOutlines(const TriangleMesh& closed, int axis, double lo, double hi);

/// `wall` with the parts of its images at distance `period` before and after it along `axis` that lie within
/// `reach` of [lo, hi] [µm].
TriangleMesh withImages(const TriangleMesh& wall, int axis, double lo, double hi, double reach);

/// The ends of a vessel along its flow axis.
struct VesselEnds {
  int axis = 0;  ///< 0, 1, 2 = x, y, z
  /// The lumen is open at both ends of the axis: the flat caps are replaced by straight continuations of the
  /// end cross-sections to `lo` and `hi` [µm], so that [lo, hi] is the extent of the container.
  double lo = 0.0, hi = 0.0;
  /// True: the container repeats with period hi - lo; false: the planes lo and hi are walls.
  bool periodic = false;
};

/// Vessel from a closed, outward-oriented mesh (see repairClosed).
///
/// Without `ends` the whole surface is wall. With `ends`, the triangles in the two planes that bound the mesh
/// along the axis are caps, not walls; each end must have at least one and can have several (a bifurcation).
/// A plane `lo` or `hi` within the mesh cuts it: closed ends are unaffected; the image of a periodic vessel
/// begins there, and the part of the mesh beyond it remains a wall, too.
///
/// volume() is that of a period if it is periodic (parts of the mesh beyond lo and hi count as straight), and
/// that of `surface` itself otherwise, without the continuation; surface() includes the continuation.
/// distance() and violation() are exact.
/// @param detail spacing at which distances can be sampled [µm]
/// @throws MeshError if an end has no flat cap or the two ends of a periodic vessel have different outlines;
/// InputError if `ends` or `detail` is invalid
std::unique_ptr<Container> makeVessel(const TriangleMesh& surface, const std::optional<VesselEnds>& ends,
                                      double detail);

}  // namespace packmesh
