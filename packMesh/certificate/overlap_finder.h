// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Search for the overlaps of cells, several times with the same neighbours, and of cells that each
/// have a mesh of their own.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <tuple>
#include <vector>

#include "packMesh/certificate/certificate.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/neighbor_search.h"
#include "packMesh/mesh/self_intersection.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/parallel/threads.h"

namespace packmesh {

class CertifiedCells {
 public:
  /// @param input must outlive this object, as must the vector it refers to
  explicit CertifiedCells(const CertificateInput& input) : input_(input) {}

  std::int64_t count() const { return static_cast<std::int64_t>(input_.cells->size()); }
  bool isOwn(std::int64_t cell) const { return input_.own == nullptr || (*input_.own)[cell]; }
  const Shape& shape(std::int64_t cell) const { return *input_.shapes[at(cell).shape]; }
  const Placement& placement(std::int64_t cell) const { return at(cell).placement; }
  const Wall* wall(std::int64_t cell) const {
    const std::size_t species = at(cell).species;
    return species < input_.walls.size() ? input_.walls[species] : nullptr;
  }
  PlacedHierarchy mesh(std::int64_t cell) const { return {shape(cell).hierarchy(), placement(cell)}; }
  Sphere sphere(std::int64_t cell) const { return boundingSphere(shape(cell).sphere(), placement(cell)); }
  double volume(std::int64_t cell) const {
    return shape(cell).volume() * std::abs(placement(cell).linear.determinant());
  }

  PeriodicNeighbors neighbors() const {
    std::vector<Sphere> spheres(count());
    input_.threads.forEachPart(count(), [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i) spheres[i] = sphere(i);
    });
    return {std::move(spheres), input_.container ? input_.container->period() : Vec3(Vec3::Zero())};
  }

  /// Calls visit(begin, end, thread) for parts of [0, count), one of the threads for each. Of many deformed
  /// cells, it frees the hierarchies from time to time: 80 kB for each.
  template <class Visit>
  void forEachPart(std::int64_t count, const Visit& visit) const {
    constexpr std::int64_t atATime = 64;
    const std::int64_t perSlice = atATime * std::max(32, 8 * input_.threads.count());
    for (std::int64_t first = 0; first < count; first += perSlice) {
      if (first > 0)
        for (const Shape* const shape : input_.shapes) shape->forgetHierarchy();
      const auto part = [&](std::int64_t begin, std::int64_t end, int thread) {
        visit(first + begin, first + end, thread);
      };
      input_.threads.forEachPart(std::min(perSlice, count - first), part, atATime);
    }
  }

  /// A lower bound of the gap of two cells [µm]: what is between their convex bounds across the line between
  /// their centres, negative if that is nothing.
  double leastGap(const NearPair& pair) const {
    const Placement &a = placement(pair.first), &b = placement(pair.second);
    const Vec3 between = a.translation - b.translation - pair.shift;
    const double distance = between.norm();
    if (!(distance > 0.0)) return -std::numeric_limits<double>::infinity();
    const Vec3 n = between / distance;
    const double reach = shape(pair.first).bound().support(a.linear.transpose() * n) +
                         shape(pair.second).bound().support(b.linear.transpose() * n);
    return distance - reach - tolerance::culling;
  }

  /// The first cell in place, the second moved by the shift. The sum is part of what is proven: the image of
  /// a cell is its mesh placed with the shifted translation.
  MeshPairResult relation(const NearPair& pair, double largestGap) const {
    Placement moved = placement(pair.second);
    moved.translation += pair.shift;
    return relate(shape(pair.first).hierarchy(), placement(pair.first), shape(pair.second).hierarchy(), moved,
                  largestGap);
  }

  /// The violation of a pair, if any.
  std::optional<OverlappingPair> faultOf(const NearPair& pair, const MeshPairResult& result) const {
    if (result.relation == MeshRelation::apart && !(result.gap < input_.requiredGap)) return {};
    const bool contained =
        result.relation == MeshRelation::firstInside || result.relation == MeshRelation::secondInside;
    return OverlappingPair{pair.first, pair.second, pair.shift, contained, result.gap};
  }

 private:
  const PlacedCell& at(std::int64_t cell) const { return (*input_.cells)[cell]; }

  const CertificateInput& input_;
};

/// Finds overlapping pairs among cells that move a little between searches.
class OverlapFinder {
 public:
  /// References its arguments. The cells may be changed between searches.
  /// @param neighbors of spheres that contain the cells in all searches, up to whole periods
  /// @param positions of the cells when the neighbours were listed
  OverlapFinder(const CertificateInput& input, const PeriodicNeighbors& neighbors,
                std::vector<Vec3> positions);

  /// The overlapping pairs that contain at least one of `moved` (each once), sorted by cell; without gaps and
  /// walls.
  std::vector<OverlappingPair> operator()(const std::vector<std::int64_t>& moved) const;

 private:
  NearPair asPlaced(const NearPair& pair) const;

  const CertificateInput& input_;
  CertifiedCells cells_;
  std::vector<Vec3> listed_;
  const PeriodicNeighbors& neighbors_;
};

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
