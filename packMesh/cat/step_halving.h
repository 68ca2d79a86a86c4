// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Taking proposed steps as far as no meshes overlap.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "packMesh/cat/growing_cells.h"
#include "packMesh/cat/growth_program.h"
#include "packMesh/certificate/certificate.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"
#include "packMesh/relaxation/body.h"
#include "packMesh/relaxation/relaxation.h"

namespace packmesh {

/// Statistics of step halving on this rank.
struct StepHalvingSums {
  std::int64_t steps = 0;           ///< proposed
  std::int64_t violatingPairs = 0;  ///< pairs that overlapped after the full steps
  std::int64_t misplaced = 0;       ///< cells not inside the lumen after the full step
  std::int64_t stayed = 0;          ///< cells whose step was halved to nothing
};

/// Keeps a state free of overlap by the exact test. A step that violates this is halved, for both cells of a
/// violating pair, and rejected below 1/8: since the previous state was valid this terminates, and nothing
/// ever shrinks.
class StepHalving {
 public:
  /// References its arguments, which must outlive this.
  StepHalving(const Physics& physics, const Execution& execution)
      : physics_(physics), execution_(execution) {}

  /// Violations of this rank's cells and of pairs with them, by index.
  Certificate examineOwn(const GrowingCells& cells) const;
  /// Violations of all cells, by id; the same on all ranks, which all call.
  Certificate examine(const GrowingCells& cells) const;

  /// Violations of some cells (indices), and of pairs with them, of a state that this rank has completely.
  Certificate examine(const std::vector<Body>& cells, const std::vector<std::int64_t>& which) const;

  /// Takes the steps as far as possible; Body::stepTaken is then the fraction taken, 1 for cells without a
  /// step. All ranks call. Pre: the state is valid; one step for each of cells.all(), those of ghosts are
  /// ignored.
  /// @param surroundings of these cells, which contain them after their steps, too
  void take(const std::vector<GrowthStep>& steps, const CellSurroundings& surroundings, GrowingCells& cells,
            StepHalvingSums& sums) const;

 private:
  PlacedCell placed(const Body& body) const {
    return {body.species, body.shape, physics_.placement(body.pose())};
  }
  std::optional<std::string> misplacement(const Body& body, const PlacedCell& cell) const;

  const Physics& physics_;
  const Execution& execution_;
};

/// Relaxes cells, enlarged to at least `scale`, as rigid bodies for at most the given number of sweeps: the
/// contact relaxation of the default method, with all constraints. If the exact test finds the
/// result free of overlap, repaired where needed, it replaces the cells. All ranks call.
/// @return whether the cells were replaced; if not, they are unchanged
bool relaxAtScale(const Physics& physics, const Execution& execution, double scale, int sweeps,
                  const std::function<bool()>& stop, GrowingCells& cells);

/// Turns placed cells into a valid initial state: cells larger than `smallest` that overlap each other, a
/// fixed cell or the wall are halved until they do not, and the remaining overlaps are resolved by relaxation
/// at those scales. All ranks call; the result does not depend on their number.
/// @param own this rank's cells: fixed ones at scale 1, existing ones at scale 1 or less, all others at
///   `smallest`
/// @return whether the cells are valid now; false: they do not fit even at this scale, or it was stopped
bool seed(const Physics& physics, const Execution& execution, double smallest,
          const std::function<bool()>& stop, std::vector<Body>& own);

}  // namespace packmesh
