// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The exact test of cells that each have a mesh of their own, such as the deformed cells of a
/// simulation.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "packMesh/certificate/certificate.h"
#include "packMesh/certificate/periodic_neighbors.h"
#include "packMesh/mesh/self_intersection_finder.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/parallel/threads.h"

namespace packmesh {

/// Meshes of several kinds that are made when they are needed, so that few are in memory at a time.
struct MeshesOfKinds {
  struct Kind {
    std::vector<Triangle> triangles;
    std::int64_t count = 0;
  };
  std::vector<Kind> kinds;  ///< numbers of meshes go through all of them
  /// Makes the vertices of a mesh [µm]. Called by several threads at once.
  std::function<void(std::size_t kind, std::int64_t index, std::vector<Vec3>& vertices)> make;
};

/// What is wrong with meshes.
struct MeshFaults {
  std::vector<OverlappingPair> overlapping;  ///< in ascending order, first <= second, without gaps
  std::vector<SelfIntersectingCell> selfIntersecting;
};

/// Tests meshes, with their periodic images, against each other and against themselves.
///
/// Overlap is decided as in certify(), by exact predicates on the vertices, among the same pairs: triangles
/// are closed sets, a mesh inside another one overlaps it, and one can meet its own image. Only triangles
/// where the boxes of two meshes have a common part are tested, without a hierarchy, whose construction takes
/// longer than the few tests of one mesh.
/// Pre: the meshes are closed, connected, outward, of finite vertices
class MeshOverlaps {
 public:
  /// @param period [µm] along each axis, 0: not periodic; meshes may lie outside the period
  MeshOverlaps(MeshesOfKinds meshes, const Vec3& period, const Threads& threads = {});

  std::int64_t count() const { return static_cast<std::int64_t>(boxes_.size()); }

  /// The faults of some of the meshes, as far as they are not those of others before them. All of [0, count)
  /// yields all faults, each once.
  MeshFaults examine(std::int64_t begin, std::int64_t end) const;

 private:
  std::size_t kindOf(std::int64_t mesh) const;
  void make(std::int64_t mesh, TriangleMesh& made) const;

  MeshesOfKinds meshes_;
  std::vector<std::int64_t> first_;  ///< of each kind
  Threads threads_;
  std::vector<Box> boxes_;
  PeriodicNeighbors neighbors_;
  std::vector<std::int32_t> order_;
  std::vector<SelfIntersectionFinder> finders_;  ///< of each kind that has meshes
};

}  // namespace packmesh
