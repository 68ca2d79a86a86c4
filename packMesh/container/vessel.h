// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Vessels: any watertight surface as a container.
#pragma once

#include <memory>
#include <optional>

#include "packMesh/container/container.h"

namespace packmesh {

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
