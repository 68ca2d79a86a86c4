// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Interface of the constructions that divide the space between cells.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/growth/cell_surroundings.h"
#include "packMesh/growth/plane_constraint.h"

namespace packmesh {

/// Request to a plane function.
struct PlaneRequest {
  const CellSurroundings& surroundings;
  std::vector<std::int64_t> wanted;  ///< cells whose planes are requested, ascending
  double detail = 1.0;               ///< fraction of the vertices to be used (eq. 3.4)
  std::int64_t count = 0;            ///< total number of cells on all ranks
  double largestRadius = 0.0;        ///< of the bounding spheres at the current scales [µm]
  /// Index of this group of cells on this rank. Unless `anew`, the surroundings have the same cells in the
  /// same order, and the groups the same members, as in the previous request.
  std::size_t batch = 0;
  bool anew = true;
};

/// Constructs, from a state free of overlap, the planes that constrain each cell. Between two cells that both
/// move, planes are at half the gap, so that both may grow up to them simultaneously; fixed cells are
/// approached up to their surface.
class PlaneFunction {
 public:
  virtual ~PlaneFunction() = default;

  /// @return the planes of each requested cell, in that order
  /// Pre: no two cells overlap. Ranks call it independently of each other.
  virtual PlaneConstraints operator()(const PlaneRequest& request) = 0;

  /// Distance from the centre of a requested cell within which other cells matter [µm], for this total number
  /// of cells.
  virtual double range(std::int64_t /*count*/) const { return 0.0; }

  /// Number of iterations for which data about the surroundings can be reused.
  virtual std::int64_t lifetime() const { return 1; }

  /// Number of cells per request, always the same cells together because the planes depend on it; 0: any.
  virtual std::int64_t cellsAtOnce() const { return 0; }
};

}  // namespace packmesh
