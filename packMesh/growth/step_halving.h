// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Proposed steps are taken as far as no meshes meet.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/certificate/certificate.h"
#include "packMesh/growth/growth_program.h"
#include "packMesh/growth/growth_state.h"

namespace packmesh {

/// What step halving took.
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

  /// Takes a state as it is.
  /// @return what is wrong with it: overlapping pairs and misplaced cells
  Certificate examine(const GrowthState& state);
  /// All ranks of the scene call with the same state. The same of some cells only: what is wrong with them,
  /// and of pairs with them.
  Certificate examine(const GrowthState& state, const std::vector<std::int64_t>& cells);

  /// Takes the steps, as far as possible. All ranks of the shares call alike. Pre: the state is valid; one
  /// step per cell
  /// @return the part of each step that was taken, 1 for cells that had nothing to do
  std::vector<double> take(const std::vector<GrowthStep>& steps, GrowthState& state, StepHalvingSums& sums,
                           const CellShares& shares = {});

 private:
  CertificateInput input() const;
  std::optional<std::string> misplacement(std::int64_t cell) const;
  Certificate faultsOf(const std::vector<std::int64_t>& cells, const CellShares& shares) const;

  const GrowthScene& scene_;
  std::vector<PlacedCell> cells_;
};

}  // namespace packmesh
