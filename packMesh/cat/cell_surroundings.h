// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cells of one rank and their neighbours.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/certificate/periodic_neighbors.h"
#include "packMesh/problem/physics.h"
#include "packMesh/relaxation/body.h"

namespace packmesh {

/// Cells of one rank, including ghosts, and how far each may move in the step for which planes are requested.
/// Sorted so that any two cells are in the same order on every rank that has both.
class CellSurroundings {
 public:
  /// References `physics` and `cells`, which must outlive it; neighbours remain those of the present cells.
  /// @param reach upper bound of the displacement of any point of each cell for which planes are made [µm]
  /// @param extent radius of a sphere around the centre that contains each cell after its step [µm]
  CellSurroundings(const Physics& physics, const std::vector<Body>& cells, std::vector<double> reach,
                   std::vector<double> extent);

  const std::vector<Body>& cells() const { return cells_; }
  double reach(std::int64_t cell) const { return reach_[cell]; }
  /// Pairs of cells (or periodic images), at least one of them in `wanted` (ascending), that can come within
  /// the clearance of each other; each once, in an order that does not depend on the rank.
  std::vector<NearPair> pairsOf(const std::vector<std::int64_t>& wanted) const;

  /// Whether a cell can come within the clearance of one that is marked.
  bool isNear(std::int64_t cell, const std::vector<char>& marked) const;

  /// Of spheres that contain the cells before and after their steps.
  const PeriodicNeighbors& neighbors() const { return neighbors_; }

 private:
  /// Calls visit(pair) for pairs with wanted(other) that can come within the clearance.
  template <class Wanted, class Visit>
  void forEachNear(std::int64_t cell, const Wanted& wanted, const Visit& visit) const;

  const std::vector<Body>& cells_;
  std::vector<double> reach_;
  std::vector<double> beyond_;  ///< by which the spheres are larger than planes require [µm]
  double clearance_;
  PeriodicNeighbors neighbors_;
};

}  // namespace packmesh
