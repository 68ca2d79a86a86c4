// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/pack.h"

#include <utility>

#include "packMesh/packing/attempt.h"
#include "packMesh/packing/densest.h"
#include "packMesh/packing/single_cell.h"
#include "packMesh/packing/validate_problem.h"
#include "packMesh/relaxation/schedule.h"

namespace packmesh {
namespace {

/// When not all cells are packed at once, that and the search for fewer of them may take so many times as
/// long as the limit says. All cells have a little less, and then it ends: who asks for more has to try
/// those first, and shall have the time for what others asked for.
constexpr double timeWithSearch = 2.0, timeForAll = 1.4;

/// Of the lumen: no cells are packed at once beyond this, not even those in columns.
constexpr double hopelessFraction = 0.66;

/// What can be packed of a problem that is hard or out of reach takes the place of the cells of `all`.
/// All cells if they can be packed in the time that is left.
Densest packFewer(const PackingProblem& problem, RunControl& control, Attempt& all) {
  const auto stopAfter = [&](double times) {
    if (control.limited()) control.stopAfter(times * problem.limits.maxSeconds);
  };
  const Communicator& ranks = problem.communicator;
  if (problem.checkpoints && problem.checkpoints->due)
    control.atPolls = [&] {
      if (ranks.any(problem.checkpoints->due())) problem.checkpoints->save(all.kept());
    };
  stopAfter(timeWithSearch);
  Densest densest;
  if (!problem.escape)  // which has done what can be done
    densest = findDensest(problem, control, [&](std::int64_t sweeps) {
      stopAfter(timeForAll);
      const bool packed = all.certifyAll(sweeps);
      if (!control.stopped()) stopAfter(timeWithSearch);
      return packed;
    });
  control.atPolls = {};
  if (control.interrupted() || densest.whole) return densest;
  if (densest.packing)
    all.take(*densest.packing);
  else
    all.leaveOutFailing();
  return densest;
}

/// What takes a while to prove is asked where packing does not succeed at once.
void requireEachFitsAlone(const PackingProblem& problem) {
  for (const Species& species : problem.species)
    if (species.count > 0)
      requireFitsAlone(species.name, *species.shape, *problem.container,
                       problem.wallClearance + species.freedom.extraWallClearance, problem.clearance);
}

}  // namespace

PackingResult pack(const PackingProblem& problem) {
  validate(problem);
  RunControl control(problem);
  Attempt all(problem, control);
  // Under a limit of time fewer cells are secured before all of them are tried for long.
  const bool secures = control.limited() && problem.limits.fewerCells;
  const bool hopeless = cellVolume(problem) > hopelessFraction * problem.container->volume();
  bool packed = all.certifyAll(secures && hopeless ? 0 : sweepsOfRelax(1));
  if (!packed && !control.interrupted() && problem.limits.fewerCells) requireEachFitsAlone(problem);
  if (!packed && !secures && !control.interrupted()) packed = all.certifyAll();
  Densest fewer;
  if (!packed && !control.interrupted() && problem.limits.fewerCells) {
    fewer = packFewer(problem, control, all);
    packed = fewer.whole;
  }
  const bool keepsFewer =
      packed || (problem.limits.fewerCells && problem.checkpoints && problem.checkpoints->endsWithFewer);
  if (problem.checkpoints) {
    if (!control.interrupted() && keepsFewer) all.keepEnd();
    if (all.hasBegun()) problem.checkpoints->save(all.kept());
  }
  PackingResult result = all.takeResult();
  result.searched = fewer.ended && !packed;
  (result.statistics.growth ? result.statistics.growth->iterations : result.statistics.sweeps) += fewer.sweeps;
  return result;
}

}  // namespace packmesh
