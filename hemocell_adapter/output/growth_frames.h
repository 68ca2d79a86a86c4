// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The states of growth as a series of files for ParaView.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "packMesh/packing/packing_problem.h"

namespace packmesh::hemocell {

/// Writes growth.pvd and membranes_0000.vtp, membranes_0001.vtp ..., all membranes at their current scales;
/// with up to `mostWithCatCells` cells also cat_cells.pvd and cat_cells_0000.vtp ..., the cells of the
/// chordal axis transform in which they grow. Polygons have the data `id`, `species` and `scale`.
class GrowthFrames {
 public:
  /// CAT cells of more cells would take longer than growth.
  static constexpr std::int64_t mostWithCatCells = 300;

  /// References the problem, which must outlive it.
  /// @param every which states are written: the first one and every so many after it
  GrowthFrames(const PackingProblem& problem, std::filesystem::path folder, std::int64_t every);

  /// To be called with this rank's cells of every state. All ranks call.
  /// @throws AgreedFailure on all ranks if a file cannot be written
  void add(const std::vector<PlacedCell>& own);

 private:
  struct Frame {
    std::int64_t number, state;
    bool catCells;
  };

  void writeCatCells(const std::vector<PlacedCell>& all, Frame& frame);
  void writeSeries() const;

  const PackingProblem& problem_;
  std::filesystem::path folder_;
  std::int64_t every_, states_ = 0;
  std::vector<Frame> frames_;
};

}  // namespace packmesh::hemocell
