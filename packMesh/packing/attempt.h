// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file One way through placement, growth or relaxation, and certificate: the one run loop.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "packMesh/certificate/certifier.h"
#include "packMesh/packing/growth_stage.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/packing/run_control.h"
#include "packMesh/packing/written_cells.h"
#include "packMesh/relaxation/relaxation.h"

namespace packmesh {

/// Tries once to pack all cells of a problem, within its limits.
/// @return all cells, certified; none when a limit was met, when the cells are jammed (see relax()), or when
/// the run was interrupted Pre: validate(problem); fixed cells are apart
PackingResult attempt(const PackingProblem& problem);

/// The same, step by step and with the states that are kept. All ranks take the same way through it.
class Attempt {
 public:
  /// References its arguments, which must outlive it.
  Attempt(const PackingProblem& problem, RunControl& control);

  /// Places the cells, or goes on from where the problem resumes, until all are certified or a limit is met,
  /// or so many sweeps (or iterations of growth) are done: called again, it then goes on as if it had not
  /// stopped.
  bool certifyAll(std::int64_t sweeps = std::numeric_limits<std::int64_t>::max());

  /// Leaves out cells until no other one fails, moving none: of each failing pair the cell that fails in more
  /// of them.
  /// @return whether that came to an end in time
  bool leaveOutFailing();

  /// Certified cells of another attempt at the same species, fewer of them, take the place of what this one
  /// has.
  void take(const PackingResult& fewer);

  /// Whether cells have been placed: there is something to keep.
  bool hasBegun() const { return relaxation_ || (growth_ && growth_->hasBegun()); }

  /// Sweeps of relaxation, or iterations of growth.
  std::int64_t sweeps() const {
    return growth_ ? growth_->iterations() : relaxation_ ? relaxation_->sweeps() : 0;
  }

  /// What has been kept last: what a run that is interrupted now can go on from.
  const PackingState& kept() const { return kept_; }
  /// Keeps the cells as they are now, with their measures, as the end of a run.
  void keepEnd();

  PackingResult takeResult();

 private:
  RelaxationInput relaxationInput() const;
  void begin();
  void resume(const PackingState& state);
  bool grown(std::int64_t iterations);
  void takeGrown();
  void relaxFrom(std::vector<Body> bodies, const RelaxationState& state = {});
  bool startsClean();
  void keepState();
  void measure();
  bool relaxed(std::int64_t maxSweeps);
  ScheduleLimits limits(std::int64_t maxSweeps);
  bool certified();
  bool certifiedOnce(std::optional<Certifier>& certifier);
  bool cleanByChance();
  Certificate examined(std::optional<Certifier>& certifier);
  bool settled(std::int64_t sweeps);
  void deliver();
  void demandDistance(const MisplacedCell& cell);
  bool isFixed(std::int64_t id) const;

  const PackingProblem& problem_;
  RunControl& control_;
  const std::int64_t cells_;  ///< asked for
  IdShares shares_;
  std::optional<GrowthStage> growth_;     ///< Method::cat
  std::optional<Relaxation> relaxation_;  ///< nothing until cells are placed, or grown
  RunPosition at_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> failures_;  ///< of pairs in the exact test
  std::map<std::int64_t, double> demandedOfWall_;  ///< by cells (ids) that were found misplaced [µm]
  WrittenCells written_;
  PackingState kept_;
  bool delivered_ = false;
  bool over_ = false;     ///< jammed, or a limit was met
  bool leftOut_ = false;  ///< cells were, so that no other one fails
  PackingResult result_;
};

}  // namespace packmesh
