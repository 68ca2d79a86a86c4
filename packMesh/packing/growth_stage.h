// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Growth as a stage of an attempt: from placement to cells of full size without overlap.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "packMesh/cat/cat_face_planes.h"
#include "packMesh/cat/growth.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/packing/run_control.h"

namespace packmesh {

/// Places the initial cells and grows them, from several random starts if they are few, and escapes from
/// local maxima if the problem requests it. All ranks call its functions together.
class GrowthStage {
 public:
  /// References its arguments, which must outlive it.
  /// @param statistics statistics of growth are added to this
  /// @param keep called at intervals, when state() can be saved
  GrowthStage(const PackingProblem& problem, RunControl& control, Statistics& statistics,
              std::function<void()> keep);

  /// Continues until the requested cells are of full size, growth has ended or is stopped, or the given
  /// number of iterations is done. @return whether they are
  bool run(std::int64_t iterations);

  /// Whether growth has ended, so that more iterations change nothing.
  bool ended() const { return ended_; }
  /// Whether there are cells.
  bool hasBegun() const { return growth_ != nullptr || bestFull_ >= 0; }
  std::int64_t iterations() const { return statistics_.growth->iterations; }

  /// This rank's cells of full size in the best state so far. After an escape they are renumbered.
  std::vector<Body> fullCells() const;
  /// Everything needed to resume from here, apart from the cells.
  GrowthPosition position() const;
  /// Of all ranks; empty for planes that need no tetrahedra.
  std::optional<TetrahedraSums> tetrahedra() const;
  /// This rank's cells in their current state.
  std::vector<Body> cells() const;

 private:
  void begin();
  void resume(const PackingState& state);
  void growFrom(std::vector<Body> cells, const GrowthProgress& from);
  void keepBest(std::vector<Body> cells);
  std::int64_t countFull(const std::vector<Body>& cells) const;
  std::vector<std::int64_t> countFullBySpecies(const std::vector<Body>& cells) const;
  bool complete(const std::vector<Body>& cells) const;
  bool anyReserve() const;
  void escapeFromBest();
  std::vector<Body> bySpecies(const std::vector<Body>& cells) const;
  double fullVolume(const std::vector<Body>& cells) const;
  std::vector<PlacedCell> placed(const std::vector<Body>& cells) const;
  bool stopped();

  const PackingProblem& problem_;
  RunControl& control_;
  Statistics& statistics_;
  std::function<void()> keep_;
  std::int64_t attempts_;
  Physics physics_;      ///< those of the problem, but with the seed of the present attempt
  Execution execution_;  ///< likewise, but interrupted at the time limit, too
  GrowthSettings settings_;
  GrowthCallbacks callbacks_;
  TetrahedraSums tetrahedra_;  ///< of this rank
  std::unique_ptr<PlaneFunction> planeFunction_;
  std::unique_ptr<Growth> growth_;
  std::int64_t attempt_ = 0;
  std::vector<Body> best_;      ///< of the attempts so far
  std::int64_t bestFull_ = -1;  ///< cells of full size in it, on all ranks
  bool ended_ = false;
};

}  // namespace packmesh
