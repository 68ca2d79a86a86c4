// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file One run through placement and relaxation, or an engine, and certificate: the main loop of pack().
/// Engines have loops of their own.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "packMesh/certificate/certifier.h"
#include "packMesh/packing/engine.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/packing/repairs.h"
#include "packMesh/relaxation/relaxation.h"
#include "packMesh/relaxation/schedule.h"

namespace packmesh {

/// One attempt to pack all cells of a problem, step by step, with the states that can be saved. All ranks
/// make the same calls.
class Attempt {
 public:
  /// References its arguments, which must outlive it.
  /// Pre: validate(problem); the fixed cells do not overlap
  Attempt(const PackingProblem& problem, RunControl& control);

  /// Places the cells, or continues from the state to resume, until all are certified, a limit is reached, or
  /// the given number of sweeps (or iterations of the engine) is done; if called again, it continues as if it
  /// had not stopped.
  bool certifyAll(std::int64_t sweeps = std::numeric_limits<std::int64_t>::max());

  /// What an engine that deforms cells has made of them, fewer if not all are done; empty if there are none,
  /// or the run is interrupted. Pre: certifyAll(), which such an engine ends
  std::optional<Physics> deformed();

  /// Removes cells until none of the others fails, without moving any: of each failing pair, the cell that
  /// fails in more pairs.
  /// @return whether this was completed in time
  bool leaveOutFailing();

  /// Replaces the cells by those of another attempt, certified: cells of the same species, all or fewer.
  void take(const PackingResult& other);

  /// The certified cells, of which the statistics are still open: all, or fewer; nullptr: none so far.
  const PackingResult* certifiedCells() const { return std::get_if<PackingResult>(&end_); }
  /// Whether they are all that were requested, however they were found.
  bool hasAllCertified() const { return certifiedCells() && certifiedCells()->outcome == Outcome::certified; }

  /// Whether cells have been placed, so that there is a state to save. Pre: states are saved
  bool hasBegun() const { return kept_.has_value(); }

  /// Sweeps of relaxation, or iterations of the engine.
  std::int64_t sweeps() const {
    return engine_ ? engine_->iterations() : placed_ ? placed_->relaxation.sweeps() : 0;
  }

  /// The state stored last, from which a run that is interrupted now can be resumed. All ranks call it. Pre:
  /// hasBegun()
  const PackingState& checkpointState();
  /// Stores the current cells, with their measures, as the final state of a run. Only takeResult() follows.
  /// Pre: there are certified cells
  void keepEnd();

  PackingResult takeResult();

 private:
  // Stages: placement or an engine, relaxation, certificate and repair.
  void begin();
  void resume(const PackingState& state);
  bool engineDone(std::int64_t iterations);
  bool relaxed(std::int64_t maxSweeps);
  bool certified();
  bool certifiedOnce(const RepairPolicy& policy, std::optional<Certifier>& certifier);
  bool settled(const RepairPolicy& policy);
  bool cleanByChance();
  bool startsClean();

  /// How far it has come: cells are still moved; they are jammed, or a limit was reached; or they are
  /// certified.
  struct GoesOn {};
  struct GivenUp {};

  /// Cells that have been placed, or taken from an engine, and are relaxed.
  struct Placed {
    Placed(const PackingProblem& problem, std::vector<Body> bodies, const RelaxationState& state,
           const RunPosition& next)
        : relaxation(problem.physics, problem.execution, std::move(bodies), state), at(next) {}
    Relaxation relaxation;
    RunPosition at;  ///< the next stage
  };
  void place(std::vector<Body> bodies, const RunPosition& at, const RelaxationState& state = {});
  /// Cells of a relaxation, some of which were put elsewhere.
  struct Relocated {
    std::vector<BodyState> cells;
    RelaxationState state;
  };
  std::optional<Relocated> relocation();
  bool certifiedWithSomeCloser();
  void place(const Relocated& relocated, const RunPosition& at);
  void takeFromEngine();
  ScheduleLimits limits(std::int64_t maxSweeps);
  CertificateInput inputNow();
  Certificate examined(const RepairPolicy& policy, std::optional<Certifier>& certifier);
  void deliver(const Certificate& certificate, bool whole = true);
  void keepState();
  bool keepMeasures();
  void endRelaxation();
  void measure();

  const PackingProblem& problem_;
  RunControl& control_;
  const std::int64_t cells_;  ///< requested
  IdShares shares_;
  std::unique_ptr<EngineStage> engine_;  ///< of PackingProblem::engine
  std::optional<Placed> placed_;         ///< empty until there are cells of full size, and after their end
  std::variant<GoesOn, GivenUp, PackingResult> end_;
  Repairs repairs_;
  WrittenCells written_;
  std::optional<PackingState> kept_;  ///< with cells of this rank, in any order, until they are needed
  Statistics statistics_;
};

}  // namespace packmesh
