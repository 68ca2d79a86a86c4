// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Interface of the constructions that divide the space between cells.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/cat/cell_planes.h"
#include "packMesh/cat/cell_surroundings.h"

namespace packmesh {

/// Request to a plane function.
struct PlaneRequest {
  const CellSurroundings& surroundings;
  std::vector<std::int64_t> wanted;  ///< cells whose planes are requested, ascending
  double detail = 1.0;               ///< fraction of the vertices to be used (eq. 3.4)
  double motion = 0.0;               ///< expected displacement of points in one iteration, growth apart [µm]
  /// Index of this group of cells on this rank. Unless `anew`, the surroundings have the same cells in the
  /// same order as in the previous request, and the same cells are requested.
  std::size_t batch = 0;
  bool anew = true;
  int thread = 0;  ///< that requests
};

/// Constructs, from a state free of overlap, the planes that constrain each cell. Between two cells that both
/// move, planes are at half the gap, so that both may grow up to them simultaneously; fixed cells are
/// approached up to their surface.
class PlaneFunction {
 public:
  virtual ~PlaneFunction() = default;

  /// Called on one thread before each of these requests is made, if they are `anew`: those of all batches.
  virtual void begin(const std::vector<PlaneRequest>& /*requests*/) {}

  /// Adds the planes of each requested cell to planes[0], planes[1] ..., in that order.
  /// Pre: no two cells overlap. Ranks call it independently of each other, and threads, each for batches of
  /// its own.
  virtual void operator()(const PlaneRequest& request, std::vector<CellPlanes>& planes) = 0;

  /// Steps rarely use all their bounds at once. Planes are requested only within this fraction of the largest
  /// displacement; overlaps after steps that went further are removed by step halving.
  virtual double expectedShare() const { return 0.4; }

  /// Number of iterations for which data about the surroundings can be reused.
  virtual std::int64_t lifetime() const { return 1; }

  /// Number of cells per request, at most, if the planes of a cell depend on the others in its request: these
  /// are then parts of blocks, the same ones on any number of ranks; 0: any.
  virtual std::int64_t cellsAtOnce() const { return 0; }
};

}  // namespace packmesh
