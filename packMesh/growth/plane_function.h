// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The interface of what divides the space between cells.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/certificate/periodic_neighbors.h"
#include "packMesh/growth/growth_scene.h"
#include "packMesh/growth/plane_constraint.h"

namespace packmesh {

/// Cells of one rank, its ghosts included, and how far each may move in the step that planes are wanted for.
/// Sorted so that any two cells are in the same order on every rank that knows both.
class CellSurroundings {
 public:
  /// References `cells`, which must outlive it.
  /// @param reach how far any point of each cell may move [µm]
  CellSurroundings(const GrowthScene& scene, const std::vector<Body>& cells, std::vector<double> reach);

  const std::vector<Body>& cells() const { return cells_; }
  double reach(std::int64_t cell) const { return reach_[cell]; }
  /// Pairs of cells (or periodic images) with at least one of `wanted` (ascending) that can come within the
  /// clearance of each other; each once, in an order that does not depend on the rank.
  std::vector<NearPair> pairsOf(const std::vector<std::int64_t>& wanted) const;

 private:
  const std::vector<Body>& cells_;
  std::vector<double> reach_;
  double clearance_;
  PeriodicNeighbors neighbors_;
};

/// What is asked of a plane function.
struct PlaneRequest {
  const CellSurroundings& surroundings;
  std::vector<std::int64_t> wanted;  ///< cells whose planes are wanted, ascending
  double detail = 1.0;               ///< fraction of the vertices to be used (eq. 3.4)
  std::int64_t count = 0;            ///< cells on all ranks
  double largestRadius = 0.0;        ///< of their bounding spheres at their present scales [µm]
  /// Number of this group of cells on this rank. Unless `anew`, the surroundings have the same cells in the
  /// same order, and the groups the same members, as when they were last asked for.
  std::size_t batch = 0;
  bool anew = true;
};

/// From a state free of overlap to the planes each cell has to stay behind. Between two cells that both move,
/// planes lie at half the gap, so that both may come up to them at the same time; fixed cells are approached
/// up to their surface.
class PlaneFunction {
 public:
  virtual ~PlaneFunction() = default;

  /// @return the planes of each wanted cell, in that order
  /// Pre: no two cells overlap. Ranks call it independently of each other.
  virtual PlaneConstraints operator()(const PlaneRequest& request) = 0;

  /// How far from a wanted cell's centre other cells matter [µm], with so many cells on all ranks.
  virtual double range(std::int64_t /*count*/) const { return 0.0; }

  /// Iterations for which what is found out of the surroundings anew can be used.
  virtual std::int64_t lifetime() const { return 1; }

  /// Cells that are to be asked for together, always the same ones, because the planes depend on it; 0: any.
  virtual std::int64_t cellsAtOnce() const { return 0; }
};

}  // namespace packmesh
