// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/clearances.h"

#include <algorithm>
#include <iterator>

namespace packmesh::hemocell {
namespace {

/// Default target of the clearances, in lattice spacings.
constexpr double wallClearanceOfRigid = 1.0, membraneRoom = 0.1;

/// Fractions of it that are tried.
constexpr double shares[] = {1.0, 0.5, 0.25, 0.0};

/// Limits of an attempt with more clearance than demanded: this many sweeps times cells, but at least the
/// smallest and at most the largest number of sweeps. HemoCell's pipe keeps the full clearance in 60 sweeps
/// at 0.45 and in 155 at 0.48, half of it in 104 at 0.50; a narrow inlet with 76 cells at 0.30 takes 544,
/// half a second. If only few contacts are left then, as in large packings, the attempt goes on to the
/// largest.
constexpr std::int64_t cheapCellSweeps = 160000, leastSweeps = 160, mostSweeps = 600;

/// The same for an engine [iterations]: in boxes and tubes it succeeded within 18 to 62, or not at all.
constexpr std::int64_t cheapIterations = 100;

/// Sweeps, or iterations of an engine, of an attempt in the search for the largest clearance, if the job has
/// no limit. With 14,000 the clearance is 7 to 33 % larger, and the search takes ten times as long.
constexpr std::int64_t thoroughSweeps = 600;

/// Time for the largest clearance if no limit is given [s]; the search ends when the step is this fraction of
/// the clearance, or this length [µm].
constexpr double defaultSearch = 60.0, finestShare = 0.02, finestStep = 0.001;

/// Fraction of the remaining time that an attempt with more clearance than demanded may take.
constexpr double shareOfTimeForClearance = 0.25;

/// Whether an existing packing is only to be certified again: it is kept unchanged.
bool givenWhole(const Problem& problem) {
  for (const CellSpecies& species : problem.species)  // profiles give initial poses to all others
    if (std::int64_t(species.fixed.size() + species.start.size()) < species.count) return false;
  return std::all_of(problem.atDemanded.parts.begin(), problem.atDemanded.parts.end(),
                     [](const Part& part) { return part.cells.placed() >= part.cells.count; });
}

/// Doubles the clearance between membranes as long as that succeeds, then halves the step.
void widen(std::int64_t sweeps, const std::function<double()>& timeLeft, const PackWith& packWith,
           PackingResult& best) {
  double lo = best.clearance, hi = 0.0;  // hi: failed; 0: nothing yet
  while (timeLeft() > 0.0) {
    const double finest = std::max(finestStep, finestShare * lo);
    if (hi > 0.0 && hi - lo <= finest) return;
    const Clearances wider = {hi > 0.0 ? 0.5 * (lo + hi) : std::max(2.0 * lo, 16.0 * finestStep),
                              best.wallClearance};
    AttemptLimits limits;
    limits.maxSweeps = sweeps;
    limits.maxSeconds = timeLeft();
    limits.fewerCells = false;
    auto result = packWith(wider, limits);
    if (result && result->outcome == Outcome::interrupted) {
      best.outcome = Outcome::interrupted;  // the state that was saved is that of its cells
      return;
    }
    if (result && result->outcome == Outcome::certified) {
      best = std::move(*result);
      lo = wider.membranes;
    } else {
      hi = wider.membranes;
    }
  }
}

}  // namespace

SearchLimits::SearchLimits(const Request& request)
    : maxSeconds(request.maxSeconds), maxIterations(request.maxIterations), soft(request.soft) {}

bool triesMoreClearance(const Request& request) {
  return !request.packCellsConventions && !request.cat.usesReserve() &&
         (request.choosesClearance() || request.choosesWallClearance() || request.largestClearance);
}

double leastWallRoom(const Request& request) {
  return *std::prev(std::end(shares), 2) * wallClearanceOfRigid * request.dx;
}

std::vector<Clearances> clearanceLevels(const Problem& problem) {
  const Clearances demanded = problem.demanded;
  if (!triesMoreClearance(problem.request) || givenWhole(problem)) return {demanded};
  const bool membranes = problem.request.choosesClearance() || problem.request.largestClearance;
  // Faces through which blood flows: the same gap to the cells beyond them.
  const double toWall = problem.lumen.solidWalls ? wallClearanceOfRigid : 0.5 * membraneRoom;
  const bool wall = problem.request.choosesWallClearance() && problem.lumen.container->wall();
  std::vector<Clearances> levels;
  for (const double share : shares) {
    Clearances level = demanded;
    if (membranes) level.membranes = std::max(demanded.membranes, share * membraneRoom * problem.request.dx);
    if (wall) level.wall = std::max(demanded.wall, share * toWall * problem.request.dx);
    levels.push_back(level);
    if (!membranes && !wall) break;
  }
  return levels;
}

PackingResult packWithClearances(const Request& request, const SearchLimits& all,
                                 const std::vector<Clearances>& levels, std::size_t first, std::int64_t cells,
                                 const std::function<double()>& elapsed, const PackWith& packWith) {
  const std::int64_t cheapSweeps =
      request.method == Method::cat
          ? cheapIterations
          : std::clamp(cheapCellSweeps / std::max<std::int64_t>(1, cells), leastSweeps, mostSweeps);
  const std::int64_t sweepsForFew = request.method == Method::cat ? 0 : mostSweeps - cheapSweeps;
  PackingResult best;
  for (std::size_t i = first; i < levels.size(); ++i) {
    const bool last = i + 1 == levels.size();
    const double left =
        all.maxSeconds > 0.0 ? std::max(all.maxSeconds - elapsed(), Limits::leastSeconds) : 0.0;
    const bool chosen = levels.back().membranes == 0.0 && levels.back().wall == 0.0;  // none is asked for
    AttemptLimits limits;
    limits.maxSeconds = left;
    limits.fewerCells = all.fewerCells;
    if (!last) {
      limits.maxSweeps = cheapSweeps;
      limits.sweepsForFew = sweepsForFew;
      limits.maxSeconds = shareOfTimeForClearance * left;
      limits.someCloser = chosen;
      limits.fewerCells = false;
    }
    auto result = packWith(levels[i], limits);
    if (!result) continue;
    best = std::move(*result);
    if (best.outcome != Outcome::outOfReach) break;
  }
  const double most = all.maxSeconds > 0.0 ? all.maxSeconds : defaultSearch;
  if (request.largestClearance && best.outcome == Outcome::certified)
    widen(
        all.maxIterations.value_or(thoroughSweeps), [&] { return most - elapsed(); }, packWith, best);
  return best;
}

}  // namespace packmesh::hemocell
