// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Packing of deformable cells, denser and in narrower lumens than undeformed cells allow.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/problem/physics.h"
#include "packMesh/soft/membrane.h"

namespace packmesh {

/// The cells of a species of the physics.
struct SoftSpecies {
  MembraneConstants membrane;
  bool rigid = false;  ///< they are placed with their full size, and stay while others grow
};

struct SoftPacking {
  Outcome outcome = Outcome::outOfReach;
  /// Of all ranks, by species of the physics, at the poses of the templates that fit best. If not all could
  /// be packed, none, or with SoftLimits::fewerCells those that could; what follows is what all of them
  /// reached. Fixed cells are left out, since they stay as they are.
  std::vector<Cell> cells;
  double startScale = 1.0;  ///< of the undeformed cells that were packed first
  double scale = 1.0;       ///< smallest of a cell at the end
  Deformation most;         ///< largest force and largest changes of a cell at the end
  bool meetsWall = false;   ///< at the end: an edge meets a wall of cubes, from which vertices are kept
  std::int64_t iterations = 0;
  /// If all could be packed and the problem has Checkpoints::due: the state before they are certified.
  std::optional<PackingState> end = {};
};

/// What deformable cells may bear. Changes of volume and area: half of the strain at which HemoCell's law of
/// volume, and that of the area of triangles, has its pole; forces are 4/3 of those of a linear law there.
struct SoftLimits {
  double force = 10.0;   ///< on a vertex, by HemoCell's laws [pN]
  double volume = 0.05;  ///< change of that of a cell [fraction]
  double area = 0.15;    ///< likewise
  double aim = 3.0;      ///< with less force than this, packing ends [pN]
  double usual = 5.0;    ///< where few cells have more force than this, they begin elsewhere [pN]

  std::int64_t iterations = 20000;
  /// If not all cells can be packed: whether those that find no room are taken out until the others can.
  bool fewerCells = false;
  bool savesFailed = true;  ///< if there are checkpoints: also of a packing that did not succeed

  double share(const Deformation& of) const;  ///< the largest, of these limits
  bool allow(const Deformation& of) const { return share(of) <= 1.0; }
};

/// Packs undeformed cells that are so small that this is easy, and lets them grow as deformable ones. Gaps
/// between cells and to the wall are at least those of the physics; constraints on positions and orientations
/// apply to the small cells, layers without cells to all. All ranks call.
///
/// From the first step of soft cells on there are checkpoints, from which it continues with the same result
/// (PackingProblem::resume); the last one is that of all cells.
///
/// `certified` means that all cells have full size and are within the limits. No step of the method lets
/// membranes meet, but in single precision: the cells are to be certified by the numbers that are written.
/// @param species those of the problem
/// @throws InputError like pack(), and if the state to continue from is of other membranes
SoftPacking packSoft(const PackingProblem& problem, const std::vector<SoftSpecies>& species,
                     const SoftLimits& limits);

/// Whether undeformed cells of full size can be packed easily, by a short attempt where they fill little of
/// the room that fixed cells leave. All ranks call, with the same arguments.
bool canPackUndeformed(const PackingProblem& problem, const std::vector<SoftSpecies>& species);

}  // namespace packmesh
