// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Any watertight surface as a container.
#pragma once

#include <memory>
#include <optional>

#include "packMesh/container/container.h"

namespace packmesh {

/// How a vessel ends along its flow axis.
struct VesselEnds {
  int axis = 0;  ///< 0, 1, 2 = x, y, z
  /// The lumen is open there: the flat caps at both ends of the axis are replaced by a straight continuation
  /// of the end cross-sections until `lo` and `hi` [µm], so that [lo, hi] is the extent of the container.
  double lo = 0.0, hi = 0.0;
  /// Whether the container repeats with period hi - lo; otherwise the planes lo and hi are walls.
  bool periodic = false;
};

/// Vessel from a closed, outward-oriented mesh (see repairClosed).
///
/// Without `ends` the whole surface is wall. With `ends`, the triangles that lie in the two planes that bound
/// the mesh along the axis are caps, no walls; there must be at least one at each end, and there may be
/// several (a bifurcation). Where `lo` or `hi` lies within the mesh, the plane cuts it: nothing changes for
/// closed ends; a periodic vessel's image begins there, and what the mesh has beyond stays a wall as well.
///
/// volume() is the volume of `surface` as given, not of its continuation; surface() includes the
/// continuation. distance() and violation() are exact.
/// @param detail spacing at which distances may be sampled [µm]
/// @throws MeshError when an end has no flat cap, or the two ends of a periodic vessel do not have the same
///   outline; InputError when the ends or `detail` make no sense
std::unique_ptr<Container> makeVessel(const TriangleMesh& surface, const std::optional<VesselEnds>& ends,
                                      double detail);

}  // namespace packmesh
