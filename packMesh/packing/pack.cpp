// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/pack.h"

#include <utility>

#include "packMesh/packing/attempt.h"
#include "packMesh/packing/densest.h"
#include "packMesh/packing/pack_by_growth.h"
#include "packMesh/packing/validate_problem.h"

namespace packmesh {
namespace {

/// The search for fewer cells may take as long again as all of them had.
constexpr double timeWithSearch = 2.0;

/// What could be packed of a problem that is out of reach takes the place of the cells of `all`.
/// @return sweeps of the search
std::int64_t packFewer(const PackingProblem& problem, RunControl& control, Attempt& all, bool& searched) {
  if (control.limited()) control.stopAfter(timeWithSearch * problem.limits.maxSeconds);
  const Communicator& ranks = problem.communicator;
  if (problem.checkpoints && problem.checkpoints->due)
    control.atPolls = [&] {
      if (ranks.any(problem.checkpoints->due())) problem.checkpoints->save(all.kept());
    };
  const Densest densest = findDensest(problem, control);
  control.atPolls = {};
  searched = densest.ended;
  if (control.interrupted()) return densest.sweeps;
  if (densest.packing)
    all.take(*densest.packing);
  else
    all.leaveOutFailing();
  return densest.sweeps;
}

PackingResult packByRelaxation(const PackingProblem& problem) {
  RunControl control(problem);
  Attempt all(problem, control);
  const bool packed = all.certifyAll();
  std::int64_t sweepsOfSearch = 0;
  bool searched = false;
  bool keepsFewer = true;
  if (!packed && !control.interrupted()) {
    if (problem.limits.fewerCells) sweepsOfSearch = packFewer(problem, control, all, searched);
    keepsFewer = problem.limits.fewerCells && problem.checkpoints && problem.checkpoints->endsWithFewer;
  }
  if (problem.checkpoints) {
    if (!control.interrupted() && keepsFewer) all.keepEnd();
    if (all.hasBegun()) problem.checkpoints->save(all.kept());
  }
  PackingResult result = all.takeResult();
  result.searched = searched;
  result.statistics.sweeps += sweepsOfSearch;
  return result;
}

}  // namespace

PackingResult pack(const PackingProblem& problem) {
  validate(problem);
  return problem.method == Method::cat ? packByGrowth(problem) : packByRelaxation(problem);
}

}  // namespace packmesh
