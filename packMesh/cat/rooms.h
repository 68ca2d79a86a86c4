// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The places of single cells: sizes that bodies reach in them while the other cells stay.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "packMesh/cat/growth.h"
#include "packMesh/mesh/mesh_tree.h"
#include "packMesh/mesh/neighbor_search.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"
#include "packMesh/relaxation/body.h"
#include "packMesh/shape/surface_distance.h"

namespace packmesh {

/// Finds holes: disjoint spheres in the free space of a packing, circumspheres of the tetrahedra between
/// cells (thesis 3.1.3), shrunk until they touch neither cell nor wall.
class Holes {
 public:
  /// References its arguments, which must outlive this.
  Holes(const Physics& physics, const Execution& execution);

  /// Holes with centres in a region, the largest first; none if TetGen fails.
  /// @param state the cells as far as they matter: if the region is only part of the container, those that
  ///   may be nearer to it than the largest radius of a shape. No hole is larger then
  /// @param region a block of the container's bounds
  /// @param least smallest radius of interest [µm]
  std::vector<Sphere> in(const Box& region, const std::vector<Body>& state, double least) const;

 private:
  struct Surroundings;
  Surroundings surroundingsOf(const Box& region, const std::vector<Body>& state) const;
  double freeAround(const Vec3& p, const Surroundings& around) const;
  std::vector<Vec3> circumcentres(const Surroundings& around) const;

  const Physics& physics_;
  const Execution& execution_;
  std::map<int, std::pair<SurfaceDistance, MeshHierarchy>> shapes_;  ///< in use, with their coarsest meshes
};

/// What is swapped between rooms: constraints and mesh of a body.
struct BodyKind {
  int species, shape;

  bool operator==(const BodyKind& other) const { return species == other.species && shape == other.shape; }
};

inline BodyKind kindOf(const Body& body) {
  return {body.species, body.shape};
}

/// Constructs a plane function for the problem that is worked on.
using PlaneFunctionFactory = std::function<std::unique_ptr<PlaneFunction>()>;

/// Growth of some cells of a state to scale 1, up to the surfaces of their neighbours, as in CAT cells: all
/// other cells stay fixed. The cost is that of the cells near them. Only this rank takes part.
class LocalGrowth {
 public:
  /// References `physics`, which must outlive this. There is no relaxation at barriers, since it would move
  /// all cells. Only the last barrier is used.
  LocalGrowth(const Physics& physics, const Execution& execution, const GrowthSettings& settings,
              const PlaneFunctionFactory& factory);

  /// Whether a cell may have its centre there; empty: anywhere.
  using Permitted = std::function<bool(const Vec3&)>;

  /// @param growing indices into the state, ascending
  /// @param state free of overlap; also on return, with no cell smaller than before. Unchanged if a cell
  ///   would end where it is not permitted
  /// @return whether all of `growing` reached scale 1
  bool grow(const std::vector<std::int64_t>& growing, const std::function<bool()>& stop,
            std::vector<Body>& state, GrowthStatistics& statistics, const Permitted& permitted = {});

  /// Whether these cells (indices, ascending) violate nothing.
  bool valid(const std::vector<std::int64_t>& cells, const std::vector<Body>& state) const;

  /// Whether the bounding spheres of two cells, both at scale 1, come nearer than `margin` [µm].
  bool near(const Body& a, const Body& b, double margin) const;

 private:
  std::vector<std::int64_t> withNeighbours(const std::vector<std::int64_t>& cells,
                                           const std::vector<Body>& state, double margin) const;

  const Physics& physics_;
  const Execution execution_;
  GrowthSettings settings_;
  std::unique_ptr<PlaneFunction> planeFunction_;
};

/// The room of a cell, its CAT cell: the space around it up to the surfaces of its neighbours, which are
/// fixed.
class Rooms {
 public:
  /// References `physics`, which must outlive this object.
  /// @param orientations number of random initial orientations per trial
  Rooms(const Physics& physics, const Execution& execution, const GrowthSettings& settings,
        const PlaneFunctionFactory& factory, int orientations);

  /// Numbers so far, which determine the random numbers of the next trial.
  struct Counters {
    std::int64_t trials = 0, iterations = 0;
  };
  /// What the trials of a part of the state have in common.
  struct Trials {
    LocalGrowth::Permitted permitted;
    std::function<bool()> stop;
    Counters counters;
  };

  /// The largest size that a body of this kind reaches in the room of `cell` in its place: the suitability
  /// score of thesis 3.1.3. Planes are recomputed as it grows.
  /// @param state changed only during the call
  /// @return its pose; empty if not even a small one fits
  std::optional<Pose> largest(std::vector<Body>& state, std::int64_t cell, const BodyKind& kind,
                              Trials& trials);

  /// Grows `cell` from its present pose. Never lowers its scale. @return whether it has its full size
  bool enlarge(std::vector<Body>& state, std::int64_t cell, Trials& trials);

  /// True if two cells could meet.
  bool neighbours(const Body& a, const Body& b) const { return growth_.near(a, b, physics_.clearance); }

  /// Whether these cells (indices, ascending) violate nothing.
  bool valid(const std::vector<std::int64_t>& cells, const std::vector<Body>& state) const {
    return growth_.valid(cells, state);
  }

 private:
  const Physics& physics_;
  LocalGrowth growth_;
  int orientations_;
};

}  // namespace packmesh
