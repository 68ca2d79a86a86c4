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
  /// References `cells`, which must outlive it.
  /// @param reach upper bound of the displacement of any point of each cell [µm]
  CellSurroundings(const Physics& physics, const std::vector<Body>& cells, std::vector<double> reach);

  const std::vector<Body>& cells() const { return cells_; }
  double reach(std::int64_t cell) const { return reach_[cell]; }
  /// Pairs of cells (or periodic images), at least one of them in `wanted` (ascending), that can come within
  /// the clearance of each other, or within `further` of that [µm]; each once, in an order that does not
  /// depend on the rank.
  std::vector<NearPair> pairsOf(const std::vector<std::int64_t>& wanted, double further = 0.0) const;

 private:
  const std::vector<Body>& cells_;
  std::vector<double> reach_;
  double clearance_;
  PeriodicNeighbors neighbors_;
};

}  // namespace packmesh
