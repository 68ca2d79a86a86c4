// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The input of a packing: plain data, no file formats.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "packMesh/analysis/cell_measures.h"
#include "packMesh/packing/packing_file.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"
#include "packMesh/relaxation/body.h"

namespace packmesh {

/// The next stage of a run. Its numbers stand in states: new stages get new ones.
enum class Stage : std::int32_t {
  relaxation = 0,   ///< continues relax()
  certificate = 1,  ///< certifies
  repair = 2,       ///< continues relaxDeepContacts(), after cells failed the certificate
  engine = 3,       ///< continues that of the engine; files have Engine::stage()
};

struct RunPosition {
  Stage stage = Stage::relaxation;
  bool fewer = false;      ///< not all cells could be packed: these are those of the densest packing found
  std::int64_t round = 0;  ///< of certificates and repairs
  SchedulePosition schedule;
};

class Hdf5Writer;

/// What an engine continues from, besides the cells. Plain data; Engine::readState() reads it.
class EngineState {
 public:
  virtual ~EngineState() = default;
  virtual std::int64_t iterations() const = 0;
  virtual const char* unit() const { return "iterations"; }  ///< of them
  /// What the attribute `iteration` of files has; 0 if iterations have a table.
  virtual std::int64_t iterationInFiles() const { return 0; }
  /// Writes what the format of states has of it. All ranks call. @param cells of the state, of this rank
  virtual void write(Hdf5Writer& out, const Physics& physics, const std::vector<BodyState>& cells) const = 0;
};

/// Of an engine whose cells have their full size.
class PastEngine final : public EngineState {
 public:
  explicit PastEngine(std::int64_t iterations) : iterations_(iterations) {}
  std::int64_t iterations() const override { return iterations_; }
  void write(Hdf5Writer& out, const Physics& physics, const std::vector<BodyState>& cells) const override;

 private:
  std::int64_t iterations_;
};

/// The same on all ranks except for `cells`, `measures` and what the engine says. Plain data. Independent of
/// the number of ranks.
struct PackingState {
  RunPosition position;
  std::int64_t repairs = 0;  ///< rounds so far
  RelaxationState relaxation;
  std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> failures;  ///< of pairs (ids)
  std::map<std::int64_t, double> demandedOfWall;                           ///< of misplaced cells (ids) [µm]
  std::shared_ptr<const EngineState> engine;                               ///< nullptr: none has worked
  std::int64_t cellCount = 0;                                              ///< on all ranks
  std::vector<BodyState> cells;     ///< of this rank, sorted by id; no cell on two ranks
  CellMeasures measures;            ///< of these cells, if the run has ended
  std::vector<CellColumn> columns;  ///< others of these cells, which are saved for readers alone
  /// To be saved with the cells: vertices of those that have meshes of their own and species with the
  /// template, in its order and frame [µm]; empty for the others. Empty: none.
  std::vector<std::vector<Vec3>> vertices;
};

/// How the states of a run are saved so that it can be resumed.
struct Checkpoints {
  /// Polled at intervals; true on any rank: save() soon. Empty: save only at the end.
  std::function<bool()> due;
  /// Called on all ranks together: soon after due(), when the run is interrupted, and when it has ended.
  std::function<void(const PackingState&)> save;
  /// Which state is saved last if the problem is not feasible: that of the fewer cells in the result, or the
  /// one before cells were removed, from which a run with higher limits can continue.
  bool endsWithFewer = false;
  bool savesFailed = true;  ///< whether the state of a packing that did not succeed is saved at its end
};

class Engine;

struct PackingProblem {
  Physics physics;  ///< what is to be packed
  std::shared_ptr<const Engine>
      engine;  ///< nullptr: cells of full size are placed at random and pushed apart
  Execution execution;
  /// Saved state to resume from; empty: start from the beginning. The rest of the run is the same as without
  /// the interruption. Pre: of the same physics and engine.
  std::optional<PackingState> resume = {};
  std::optional<Checkpoints> checkpoints = {};
};

}  // namespace packmesh
