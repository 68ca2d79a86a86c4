// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/pack.h"

#include <utility>

#include "packMesh/packing/attempt.h"
#include "packMesh/packing/densest.h"
#include "packMesh/packing/engine.h"
#include "packMesh/packing/validate_problem.h"
#include "packMesh/relaxation/schedule.h"

namespace packmesh {
namespace {

/// If not all cells are packed at once, packing them and the search for fewer of them may take this multiple
/// of the time limit. The attempt at all cells ends slightly earlier: a larger request has to try these
/// first, and must have the time that smaller requests have.
constexpr double timeWithSearch = 2.0, timeForAll = 1.4;

/// Volume fraction beyond which packing all cells is not attempted first, not even in columns.
constexpr double hopelessFraction = 0.66;

/// Replaces the cells of `all` by the largest certified number found, for a problem that is difficult or
/// infeasible. All cells if they can be packed in the remaining time.
Densest packFewer(const PackingProblem& problem, RunControl& control, Attempt& all) {
  const auto stopAfter = [&](double times) {
    if (control.limited()) control.stopAfter(times * problem.execution.limits.maxSeconds);
  };
  const Communicator& ranks = problem.execution.communicator;
  if (problem.checkpoints && problem.checkpoints->due)
    control.atPolls = [&] {
      if (all.hasBegun() && ranks.any(problem.checkpoints->due())) problem.checkpoints->save(all.kept());
    };
  stopAfter(timeWithSearch);
  Densest densest = findDensest(problem, control, [&](std::int64_t sweeps) {
    stopAfter(timeForAll);
    const bool packed = all.certifyAll(sweeps);
    if (!control.stopped()) stopAfter(timeWithSearch);
    return packed;
  });
  control.atPolls = {};
  if (control.interrupted() || densest.whole) return densest;
  // The state of the engine may be denser than what the search has found.
  const bool keepsOwn =
      ((problem.engine && problem.engine->canExceedTrials()) || !densest.packing) && all.leaveOutFailing();
  if (densest.packing &&
      !(keepsOwn && all.certifiedCells()->certificate.cellVolume >= densest.packing->certificate.cellVolume))
    all.take(*densest.packing);
  return densest;
}

}  // namespace

PackingResult pack(const PackingProblem& problem) {
  validate(problem);
  RunControl control(problem);
  Attempt all(problem, control);
  // With a time limit, a packing of fewer cells is secured before all of them are tried for long.
  const bool secures = control.limited() && problem.execution.limits.fewerCells;
  const bool hopeless = cellVolume(problem) > hopelessFraction * problem.physics.container->volume();
  bool packed = all.certifyAll(secures && hopeless ? 0 : sweepsOfRelax(1));
  if (!packed && !secures && !control.interrupted()) packed = all.certifyAll();
  Densest fewer;
  if (!packed && !control.interrupted() && problem.execution.limits.fewerCells) {
    fewer = packFewer(problem, control, all);
    packed = fewer.whole;
  }
  const bool keepsFewer = problem.execution.limits.fewerCells && problem.checkpoints &&
                          problem.checkpoints->endsWithFewer && all.certifiedCells();
  if (problem.checkpoints) {
    if (!control.interrupted() && (packed || keepsFewer)) all.keepEnd();
    if (all.hasBegun()) problem.checkpoints->save(all.kept());
  }
  PackingResult result = all.takeResult();
  result.searched = fewer.ended && !packed;
  result.statistics.searching = fewer.sweeps;
  return result;
}

}  // namespace packmesh
