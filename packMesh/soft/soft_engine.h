// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The engine of deformable cells, denser and in narrower lumens than undeformed cells allow.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "packMesh/packing/engine.h"
#include "packMesh/soft/membrane.h"
#include "packMesh/soft/small_cells.h"
#include "packMesh/soft/soft_cells.h"

namespace packmesh {

/// The stage in which cells are soft, in progress and states.
inline constexpr const char* softCellsStage = "soft cells";

/// What deformable cells may bear. Changes of volume and area: half of the strain at which HemoCell's law of
/// volume, and that of the area of triangles, has its pole; forces are 4/3 of those of a linear law there.
struct SoftLimits {
  double force = 10.0;   ///< on a vertex, by HemoCell's laws [pN]
  double volume = 0.05;  ///< change of that of a cell [fraction]
  double area = 0.15;    ///< likewise
  double aim = 3.0;      ///< with less force than this, packing ends [pN]
  double usual = 5.0;    ///< where few cells have more force than this, they begin elsewhere [pN]

  double share(const Deformation& of) const;  ///< the largest, of these limits
  bool allow(const Deformation& of) const { return share(of) <= 1.0; }
};

/// What all of the requested cells have reached, also those that are left out.
class SoftStatistics final : public EngineStatistics {
 public:
  double startScale = 1.0;  ///< of the undeformed cells that were packed first
  double scale = 0.0;       ///< smallest of a cell at the end; 0: no small cells could be packed
  Deformation most;         ///< largest force and largest changes of a cell at the end
  bool meetsWall = false;   ///< at the end: an edge meets a wall of cubes, from which vertices are kept
  bool atRest = false;      ///< more iterations would change little
  bool succeeded = false;   ///< all have full size within the limits; the certificate may fail
  std::int64_t done = 0;    ///< iterations

  std::int64_t iterations() const override { return done; }
  std::vector<std::string> lines(const Statistics&) const override { return {}; }
  std::string json() const override { return "{}"; }
};

/// Whether cells are at rest, and what decides it.
struct SoftRest {
  bool reached = false;
  double tolerance = 1.0;    ///< usual force of the method with which they are at rest [pN]
  double forceBefore = 0.0;  ///< HemoCell's at the last decision; 0: none since folds were opened [pN]
  int unfolded = 0;          ///< how often sharp folds were opened
};

/// What soft cells continue from; the cells of the state are those that were to become soft.
struct SoftState final : EngineState {
  std::string membranes;  ///< what is told apart, besides the problem
  int attempt = 0;
  double startScale = 1.0;
  SoftRest rest;
  /// Of attempts within the limits but with unusual forces, the one with the least; -1: none.
  int bestAttempt = -1;
  double bestForce = 0.0, bestScale = 0.0;
  bool repeats = false;  ///< this attempt is that one again
  SoftCellsState cells;

  std::int64_t iterations() const override { return cells.iterations; }
  const char* unit() const override { return "iterations of soft cells"; }
  std::int64_t iterationInFiles() const override { return cells.iterations; }
  void write(Hdf5Writer& out, const Physics& physics, const std::vector<BodyState>& placed) const override;
};

/// Packs undeformed cells that are so small that this is easy, and lets them grow as deformable ones. Gaps
/// between cells and to the wall are at least those of the physics; constraints on positions and orientations
/// apply to the small cells, layers without cells to all.
///
/// From the first step of soft cells on there are states. No step of the method lets membranes meet, but in
/// single precision: pack() certifies the cells by the numbers that are written.
class SoftEngine final : public Engine {
 public:
  std::vector<SoftSpecies> species;  ///< those of the problem
  SoftLimits limits;
  /// The physics in which cells of all ranks have their places, as they will be written, given those that
  /// were not fixed. Empty: placedIn().
  std::function<Physics(const std::vector<Cell>&)> written;

  StageInFiles stage() const override { return {4, softCellsStage}; }
  std::shared_ptr<const EngineState> readState(const Hdf5Reader& in, const PackingProblem& problem,
                                               std::int64_t first,
                                               std::vector<BodyState>& cells) const override;
  bool deforms() const override { return true; }
  void validate(const PackingProblem& problem) const override;
  void addTo(Digest&) const override {}
  std::shared_ptr<EngineStatistics> statistics(std::int64_t iterations) const override;
  /// @throws InputError if the state to continue from is of other membranes
  std::unique_ptr<EngineStage> begin(const PackingProblem& problem, RunControl& control,
                                     Statistics& statistics, std::function<void()> keep) const override;
};

/// The physics with these cells of its species at their places, besides those that are fixed.
Physics placedIn(const Physics& physics, const std::vector<Cell>& cells);

}  // namespace packmesh
