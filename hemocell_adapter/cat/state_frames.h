// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The states of growth as a series of files for ParaView.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "hemocell_adapter/output/output_plan.h"
#include "packMesh/packing/packing_problem.h"

namespace packmesh::hemocell {

/// Writes the states to a folder, as state_<number>.h5 (packing_file.h, with `scale`), and with up to
/// `mostWithCatCells` cells cat_cells_<number>.h5 (packing_file.h): the cells of the chordal axis transform
/// in which they grow. The command packmesh makes the series of them.
class StateFrames {
 public:
  /// CAT cells of more cells would take longer than growth.
  static constexpr std::int64_t mostWithCatCells = 300;

  /// Removes files of earlier series. References the problem, which must outlive it. All ranks call.
  StateFrames(const PackingProblem& problem, const FrameSeries& series);

  /// Folder of the series among the outputs.
  static std::filesystem::path folderIn(const std::filesystem::path& outputs) {
    return outputs / "growth_frames";
  }

  /// To be called with this rank's cells of every state. All ranks call.
  /// @throws AgreedFailure on all ranks if a file cannot be written
  void add(const std::vector<PlacedCell>& own);

  /// Has packmesh make growth.pvd and membranes_0000.vtp ..., all membranes at their current scales, and
  /// cat_cells.pvd and cat_cells_0000.vtp ...; then the states are removed. A warning says if it cannot. All
  /// ranks call.
  void convert() const;

 private:
  const PackingProblem& problem_;
  std::filesystem::path folder_;
  std::int64_t every_, states_ = 0;
};

}  // namespace packmesh::hemocell
