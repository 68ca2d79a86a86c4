// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Engines: what brings cells to full size without overlap, in place of placement and relaxation.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/packing/run_control.h"

namespace packmesh {

class Digest;

/// The stage of an attempt in which an engine works, from placement to the first certificate. All ranks call
/// its functions together.
class EngineStage {
 public:
  virtual ~EngineStage() = default;

  /// Continues until the requested cells are of full size, the stage has ended or is stopped, or the given
  /// number of iterations is done. @return whether they are
  virtual bool run(std::int64_t iterations) = 0;

  /// Whether it has ended, so that more iterations change nothing.
  virtual bool ended() const = 0;
  /// Whether there are cells.
  virtual bool hasBegun() const = 0;
  virtual std::int64_t iterations() const = 0;

  /// This rank's cells in their current state.
  virtual std::vector<Body> cells() const = 0;
  /// Everything needed to resume from here, apart from the cells.
  virtual EnginePosition save() const = 0;
  /// This rank's cells of full size in the best state so far, with any ids; completes the statistics.
  virtual std::vector<Body> take() = 0;
};

/// An engine with its settings.
class Engine {
 public:
  virtual ~Engine() = default;

  /// @throws InputError if the problem cannot be packed with these settings
  virtual void validate(const PackingProblem& problem) const = 0;
  /// Adds what states of problems with different settings are told apart by.
  virtual void addTo(Digest& digest) const = 0;
  /// Statistics of a run that has done so many iterations.
  virtual std::shared_ptr<EngineStatistics> statistics(std::int64_t iterations) const = 0;

  /// Continues from PackingProblem::resume if that is a state of the engine. References its arguments, which
  /// must outlive the stage.
  /// @param statistics are added to
  /// @param keep called at intervals, when the state can be saved
  virtual std::unique_ptr<EngineStage> begin(const PackingProblem& problem, RunControl& control,
                                             Statistics& statistics, std::function<void()> keep) const = 0;

  /// The engine for trials in the search for the densest packing of fewer cells.
  virtual std::shared_ptr<const Engine> forTrials() const = 0;
  /// Whether its result can be denser than what that search finds.
  virtual bool canExceedTrials() const = 0;
};

}  // namespace packmesh
