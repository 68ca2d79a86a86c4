// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The small undeformed cells from which soft ones grow, and what they grow by.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "packMesh/packing/engine.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/problem/physics.h"
#include "packMesh/soft/membrane.h"
#include "packMesh/soft/soft_cells.h"

namespace packmesh {

/// The cells of a species of the physics.
struct SoftSpecies {
  MembraneConstants membrane;
  bool rigid = false;  ///< they are placed with their full size, and stay while others grow
};

/// What of a problem is soft, and the numbers of the method for it. References the problem.
struct SoftModel {
  /// @param species those of the problem
  SoftModel(const PackingProblem& problem, const std::vector<SoftSpecies>& species);

  const PackingProblem& problem;
  const Physics& physics;
  // Of each species:
  std::vector<std::shared_ptr<const Membrane>> membranes;
  std::vector<char> grows;  ///< whether its cells are soft
  std::vector<int> wallOf;  ///< index into `walls`; -1: none
  std::vector<WallGap> walls;
  SoftSettings settings;
  // Shares of the lumen that cells fill: all, those that are fixed, those that are soft.
  double filled = 0.0, fixed = 0.0, growing = 0.0;
  std::string membranesDigest;  ///< of what is not in the physics

  /// A cell with these vertices. @param scale of its membrane, if it is soft
  SoftCell cell(const BodyState& placed, std::vector<Vec3> vertices, double scale) const;
  bool isSoft(const BodyState& cell) const { return grows[cell.species] != 0; }
};

/// Undeformed cells of all ranks at a scale, apart from those that do not grow.
struct SmallCells {
  int attempt = 0;
  double scale = 1.0;
  Physics physics;  ///< with shapes of this scale
  std::vector<BodyState> placed;

  std::vector<Vec3> vertices(const BodyState& cell) const;
};

/// Packs small cells, as large as that is easy. All ranks call. @param before the attempt before this one
/// @return nothing if it does not succeed
/// @throws InputError like pack()
std::optional<SmallCells> packSmallCells(const SoftModel& model, RunControl& control, int attempt,
                                         double scaleBefore);

/// The same cells, from a state.
SmallCells smallCellsOf(const SoftModel& model, int attempt, double scale, std::vector<BodyState> placed);

/// Whether undeformed cells of full size can be packed easily, by a short attempt where they fill little of
/// the room that fixed cells leave. All ranks call, with the same arguments.
bool canPackUndeformed(const PackingProblem& problem, const std::vector<SoftSpecies>& species);

}  // namespace packmesh
