// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The part of the cells' surfaces between which the space is divided. Internal to packMesh/cat.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "packMesh/cat/chord_planes.h"
#include "packMesh/cat/levels_of_detail.h"
#include "packMesh/cat/plane_function.h"
#include "packMesh/cat/tetrahedra.h"

namespace packmesh {

/// The cells of a request and those that come within their reach, with the images of cells that do.
struct ReachedBodies {
  std::vector<std::int64_t> members;   ///< cells, ascending
  std::vector<TetrahedraBody> bodies;  ///< members are their objects; by member, then by shift
  std::vector<NearPair> pairs;         ///< of cells, at least one of them requested
};

ReachedBodies bodiesWithinReach(const PlaneRequest& request);

/// A mesh of a cell in its body frame, and which of its vertices are points.
struct ReachingMesh {
  MeshHierarchy hierarchy;
  /// Those that are whatever is within reach: corners of triangles so large that they can face another
  /// surface although no corner is within reach of it.
  std::vector<char> always;
  /// Distances from other surfaces up to which they are [µm at scale 1]: those that a coarser level of detail
  /// has, too, are farther.
  std::vector<double> within;
};

/// The meshes of all levels of detail of a shape, finest first.
/// @param size cube root of the volume [µm]
std::vector<std::unique_ptr<const ReachingMesh>> reachingMeshes(const LevelsOfDetail& levels, double size);

/// Which vertices of each body are points: those within reach of the body that it is near to, as far as their
/// level of detail counts, and those that share a triangle with them. A body that is not requested has those
/// near to a requested one.
/// @param meshes of the members
std::vector<std::vector<char>> pointsWithinReach(const PlaneRequest& request, const ReachedBodies& reached,
                                                 const std::vector<const ReachingMesh*>& meshes,
                                                 const ChordPlanes& chords);

}  // namespace packmesh
