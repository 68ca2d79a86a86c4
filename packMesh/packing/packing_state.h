// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A packing on its way: all that the way from here to the end depends on, besides the problem.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "packMesh/analysis/cell_measures.h"
#include "packMesh/growth/growth.h"
#include "packMesh/relaxation/body_state.h"
#include "packMesh/relaxation/relaxation_state.h"
#include "packMesh/relaxation/schedule.h"

namespace packmesh {

/// What a run does next.
enum class Stage : std::int32_t {
  relaxation = 0,   ///< goes on with relax()
  certificate = 1,  ///< certifies
  repair = 2,       ///< goes on with settle(), after cells failed the certificate
  growth = 4,       ///< goes on with grow(); with Method::cat the only one besides `certificate`
};

struct RunPosition {
  Stage stage = Stage::relaxation;
  bool fewer = false;      ///< not all cells fitted: these are those of the densest packing found
  std::int64_t round = 0;  ///< of certificates and repairs
  SchedulePosition schedule;
};

/// Where growth is, see grow() and PackingProblem::growth.
struct GrowthPosition {
  std::int64_t attempt = 0;
  std::int64_t iterations = 0;  ///< of all attempts
  GrowthProgress progress;
  std::vector<BodyState> best;  ///< of earlier attempts
};

/// The same on all ranks but for `cells` and `measures`. Plain data. It does not depend on the number of
/// ranks.
struct PackingState {
  RunPosition position;
  std::int64_t repairs = 0;  ///< rounds so far
  RelaxationState relaxation;
  std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> failures;  ///< of pairs (ids)
  std::map<std::int64_t, double> demandedOfWall;                           ///< of misplaced cells (ids) [µm]
  GrowthPosition growth;                                                   ///< with Method::cat
  std::int64_t cellCount = 0;                                              ///< on all ranks
  std::vector<BodyState> cells;  ///< of this rank, sorted by id; no cell on two ranks
  CellMeasures measures;         ///< of these cells, when the run has ended
};

/// How a run is kept, so that another one can go on with it.
struct Checkpoints {
  /// Asked now and then; true on any rank: save() soon. Empty: only at the end.
  std::function<bool()> due;
  /// Called on all ranks together: at once after due(), when the run is interrupted, and when it has ended.
  std::function<void(const PackingState&)> save;
  /// Which state is the last of a run that is out of reach: the one of the fewer cells it ended with, or the
  /// one before cells were taken out, from which a run with higher limits goes on.
  bool endsWithFewer = false;
};

}  // namespace packmesh
