// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Growth as a stage of an attempt: from nothing to cells of full size, free of overlap.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "packMesh/growth/growth.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/packing/run_control.h"

namespace packmesh {

/// A problem as growth sees it. References the problem, which must outlive it.
GrowthScene growthSceneOf(const PackingProblem& problem);

/// Seeds the cells and grows them, from several random starts if they are few, and escapes local maxima where
/// the problem asks for it. All ranks call its functions together.
class GrowthStage {
 public:
  /// References its arguments, which must outlive it.
  /// @param statistics what growth takes is added here
  /// @param keep called now and then: state() can be kept
  GrowthStage(const PackingProblem& problem, RunControl& control, Statistics& statistics,
              std::function<void()> keep);

  /// Goes on until the cells asked for are of full size, growth has ended, is stopped, or has done so many
  /// iterations. @return whether they are
  bool run(std::int64_t iterations);

  /// Whether more iterations could change anything.
  bool ended() const { return ended_; }
  /// Whether there are cells.
  bool hasBegun() const { return growth_ != nullptr || bestFull_ >= 0; }
  std::int64_t iterations() const { return statistics_.growth->iterations; }

  /// This rank's cells of full size in the best state so far. After an escape they are numbered anew.
  std::vector<Body> fullCells() const;
  /// What it takes to go on from here, apart from the cells.
  GrowthPosition position() const;
  /// Of all ranks; nothing for planes that need no tetrahedra.
  std::optional<TetrahedraSums> tetrahedra() const;
  /// This rank's cells as they are now.
  std::vector<Body> cells() const;

 private:
  void begin();
  void resume(const PackingState& state);
  void growFrom(std::vector<Body> cells, const GrowthProgress& from);
  void keepBest(std::vector<Body> cells);
  std::int64_t countFull(const std::vector<Body>& cells) const;
  bool complete(const std::vector<Body>& cells) const;
  bool anyReserve() const;
  void escapeFromBest();
  double fullVolume(const std::vector<Body>& cells) const;
  std::vector<PlacedCell> placed(const std::vector<Body>& cells) const;
  bool stopped();

  const PackingProblem& problem_;
  RunControl& control_;
  Statistics& statistics_;
  std::function<void()> keep_;
  std::int64_t attempts_;
  GrowthScene scene_;
  GrowthSettings settings_;
  GrowthCallbacks callbacks_;
  TetrahedraSums tetrahedra_;  ///< of this rank
  std::unique_ptr<PlaneFunction> planeFunction_;
  std::unique_ptr<Growth> growth_;
  std::int64_t attempt_ = 0;
  std::vector<Body> best_;  ///< of the attempts so far
  std::int64_t bestFull_ = -1;  ///< cells of full size in it, on all ranks
  bool ended_ = false;
};

}  // namespace packmesh
