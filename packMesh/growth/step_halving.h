// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Proposed steps are taken as far as no meshes meet.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "packMesh/certificate/certificate.h"
#include "packMesh/growth/growing_cells.h"
#include "packMesh/growth/growth_program.h"

namespace packmesh {

/// What step halving took; on this rank.
struct StepHalvingSums {
  std::int64_t steps = 0;           ///< proposed
  std::int64_t violatingPairs = 0;  ///< that met after the full steps
  std::int64_t misplaced = 0;       ///< cells not inside the lumen after the full step
  std::int64_t stayed = 0;          ///< cells whose step was halved to nothing
};

/// Keeps a state free of overlap by the exact test. A step that breaks it is halved, for both cells of an
/// offending pair, and below 1/8 not taken: as the state before was valid this ends, and nothing ever
/// shrinks.
class StepHalving {
 public:
  /// References the scene, which must outlive this.
  explicit StepHalving(const GrowthScene& scene) : scene_(scene) {}

  /// What is wrong with this rank's cells and pairs with them, by index.
  Certificate examineOwn(const GrowingCells& cells) const;
  /// What is wrong with all cells, by id; the same on all ranks, which all call.
  Certificate examine(const GrowingCells& cells) const;

  /// What is wrong with some cells (indices), and pairs with them, of a state that this rank knows wholly.
  Certificate examine(const std::vector<Body>& cells, const std::vector<std::int64_t>& which) const;

  /// Takes the steps, as far as possible; Body::stepTaken then says how far, 1 for cells that had nothing to
  /// do. All ranks call. Pre: the state is valid; one step for each of cells.all(), of which those of ghosts
  /// do not matter
  void take(const std::vector<GrowthStep>& steps, GrowingCells& cells, StepHalvingSums& sums) const;

 private:
  PlacedCell placed(const Body& body) const { return {body.species, scene_.placement(body.pose())}; }
  std::optional<std::string> misplacement(const Body& body, const PlacedCell& cell) const;

  const GrowthScene& scene_;
};

}  // namespace packmesh
