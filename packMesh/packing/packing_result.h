// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The result of pack().
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "packMesh/certificate/certificate.h"
#include "packMesh/core/pose.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

enum class Outcome {
  certified,    ///< all requested cells, certificate clean
  outOfReach,   ///< a limit was reached before all cells were free of overlap: fewer cells, certified
  interrupted,  ///< stopped on request
};

struct Statistics;

/// What an engine counts.
class EngineStatistics {
 public:
  virtual ~EngineStatistics() = default;
  virtual std::int64_t iterations() const = 0;
  /// Sentences for people. @param all of the run
  virtual std::vector<std::string> lines(const Statistics& all) const = 0;
  /// Members of `statistics` in reports, as text of a JSON object.
  virtual std::string json() const = 0;
};

struct Statistics {
  std::int64_t blocks = 0;     ///< number of blocks of the domain; additional ranks are idle
  std::int64_t sweeps = 0;     ///< of the relaxation
  std::int64_t repairs = 0;    ///< rounds in which pairs failing the exact test got more clearance
  std::int64_t searching = 0;  ///< sweeps or iterations of the search for fewer cells
  std::shared_ptr<const EngineStatistics> engine;  ///< of PackingProblem::engine
  /// CPU time of this rank [s]
  double placementSeconds = 0.0, relaxationSeconds = 0.0, engineSeconds = 0.0, certificateSeconds = 0.0;

  /// All sweeps of relaxation, or iterations of the engine, and what they are called.
  std::int64_t effort() const { return (engine ? engine->iterations() : sweeps) + searching; }
  const char* unit() const { return engine ? "iterations" : "sweeps"; }
};

/// Of cells that an engine has given meshes of their own.
struct DeformedResult {
  std::shared_ptr<const Physics> physics;          ///< to which the cells refer, in place of the problem's
  std::shared_ptr<const EngineStatistics> engine;  ///< what it took before their certificate
};

/// Cells with what is known of them.
struct PackingResult {
  Outcome outcome = Outcome::certified;
  /// Least gaps between membranes and to the wall that were required of the cells [µm].
  double clearance = 0.0, wallClearance = 0.0;
  /// Sorted by species, then by id: of this rank, preceded by those of lower ranks. All requested cells if
  /// certified (and those from a reserve); if not feasible, the densest certified packing found (see
  /// `searched`), or none without Limits::fewerCells; none if interrupted.
  std::vector<PlacedCell> cells;
  std::vector<Pose> poses;           ///< the same cells as poses
  std::vector<std::int64_t> counts;  ///< number of this rank's cells of each species of the problem
  std::int64_t cellCount = 0;        ///< of all ranks
  /// If not feasible: the search for the densest packing was completed. Otherwise it was stopped by the time
  /// limit, and the cells are merely some that could be certified.
  bool searched = false;
  bool late = false;                       ///< the time limit had to do with the outcome
  std::optional<DeformedResult> deformed;  ///< of an engine that deforms cells, if it has packed any
  Certificate certificate;                 ///< of exactly the `cells` of all ranks; pairs and cells by id
  Statistics statistics;
};

}  // namespace packmesh
